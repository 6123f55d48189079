#pragma once
// The crane's equations of motion in closed form (plant-and-bus.md 1.2 and 1.3): slewing, luffing jib crane on a
// gantry, with hoist, two sway angles and a rotator. Coordinates q = (s, psi, phi, l, alpha, beta, kappa), metres and
// radians.
//
//   M(q) qdd + h(q, qd) + g(q) = B F - friction - sway damping + external
//
// With CraneParameters::machine it is a ship-to-shore gantry: psi held at pi/2, phi the trolley's place in m.
//
// The payload is a mass that translates without tilting on an inextensible rope; its yaw is psi + kappa.
#include <array>

#include "plant/parameters/config.hpp"

namespace plant {

inline constexpr int crane_size = 7;
enum Coordinate : std::uint8_t { Q_S, Q_PSI, Q_PHI, Q_L, Q_ALPHA, Q_BETA, Q_KAPPA };
inline constexpr std::array<Coordinate, joint_count> joint_coordinate = {Q_S, Q_PSI, Q_PHI, Q_L, Q_KAPPA};
inline constexpr std::size_t coordinate_of(std::size_t joint) { return joint_coordinate[joint]; }

using CraneVector = std::array<double, crane_size>;
using CraneMatrix = std::array<CraneVector, crane_size>;

// The load on the rope. mass 0: nothing (level L2, where the payload is a body of its own and pulls through
// `external`).
struct Payload {
  double mass;     // kg
  double inertia;  // kg m2 about the vertical
};

// Root-free Cholesky factors of a mass matrix's rows and columns of free coordinates.
struct Factors {
  CraneMatrix lower;                 // below the diagonal; each column still times its pivot
  CraneVector inverse;               // of the pivots
  unsigned locked;                   // bits of the locked coordinates
  void solve(CraneVector& b) const;  // b becomes the solution, 0 for the locked ones
};

class Crane {
 public:
  explicit Crane(const CraneParameters& parameters);
  const CraneParameters& parameters() const { return p_; }

  CraneMatrix mass_matrix(const CraneVector& q, const Payload&) const;  // rotor inertias included
  CraneVector bias(const CraneVector& q, const CraneVector& qd,
                   const Payload&) const;                                 // h: centrifugal and Coriolis forces
  CraneVector gravity_force(const CraneVector& q, const Payload&) const;  // g
  double kinetic_energy(const CraneVector& q, const CraneVector& qd, const Payload&) const;  // J
  double potential_energy(const CraneVector& q, const Payload&) const;                       // J, zero at z = 0

  // The part of the accelerations that follows from the state alone, without the drives.
  struct Dynamics {
    Factors mass;                // M on the free coordinates
    CraneVector resisting;       // h + g
    Joints direction, stribeck;  // dry friction of the free joints: smooth sign of the speed, share of the bump
  };
  // Coordinates with a bit set in `locked` are held at qdd = 0 (sway angles at L0 and L2, brakes).
  Dynamics dynamics(const CraneVector& q, const CraneVector& qd, const Payload&, unsigned locked) const;
  // qdd for given generalised forces.
  static CraneVector acceleration(const Dynamics&, const CraneVector& force);
  // Solves M x = b on the free coordinates, 0 on the locked ones.
  static CraneVector solve(const CraneMatrix& m, const CraneVector& b, unsigned locked);

  // Friction force of an actuated joint at joint speed v, against v. sliding: 0 smooths dry friction around v = 0; 1
  // and -1 use its full value, for a joint known to slide in that direction (stiction).
  double friction(int joint, double v, int sliding = 0) const;
  // The force or torque at the joint, behind the gear, N or N m, for a motor torque in N m behind the lag: gear times
  // efficiency times torque, as in plant-and-bus.md 1.3; with gear_losses gear / efficiency when the load drives the
  // motor, smooth around rest.
  double gear_force(std::size_t joint, double torque, double v) const;
  // gear_force minus friction, for the joints whose coordinates are free.
  Joints drive_forces(const Joints& torque, const CraneVector& qd, const std::array<std::int8_t, joint_count>& sliding,
                      const Dynamics&) const;
  double static_friction(int joint) const;  // F_s, N or N m: what a stuck joint withstands
  // Viscous sway coefficients, N m s/rad, for the present rope.
  double sway_damping(double l, double mass) const;

  std::array<double, 3> tip(const CraneVector& q) const;
  std::array<double, 3> payload_position(const CraneVector& q) const;
  std::array<double, 3> tip_by_luff(const CraneVector& q) const;  // d tip / d phi, world axes
  std::array<double, 3> tip_velocity(const CraneVector& q, const CraneVector& qd) const;
  std::array<double, 3> payload_velocity(const CraneVector& q, const CraneVector& qd) const;
  // Generalised force (or momentum) of a force (or momentum) at the payload, in world axes.
  CraneVector at_payload(const CraneVector& q, const std::array<double, 3>& world) const;
  double tension(const CraneVector& q, const CraneVector& qd, const CraneVector& qdd, double mass) const;  // N, rope

 private:
  // A joint's constants, from its drive's parameters.
  struct JointForces {
    double smooth;      // joint speed within which dry friction changes its sign
    double coulomb;     // N or N m
    double bump;        // height of the Stribeck curve at rest
    double bump_speed;  // speed at which it has fallen to 1 / e
    double viscous;     // per unit of joint speed
    double gear;        // times efficiency
    double half_gear;
    double either_way, loss;  // the gear's 1 / efficiency + efficiency, and - efficiency
  };
  double direction(const JointForces& joint, double v) const;
  double bump_exponent(const JointForces& joint, double v) const;
  double friction_towards(const JointForces& joint, double v, double direction, double bump) const;
  double behind_gear(std::size_t joint, double torque, double direction) const;

  CraneParameters p_;
  std::array<JointForces, joint_count> joints_;
};

// Inverse kinematics, plant-and-bus.md 1.2. Throws std::invalid_argument for a pose out of reach or beyond a joint
// limit.
CraneVector inverse_kinematics(const CraneParameters&, const CranePose&);

}  // namespace plant
