#pragma once
// The moving crane: equations of motion, drives, friction and brakes, integrated over an interval with constant
// commands.
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "plant/crane/crane.hpp"
#include "plant/numerics/integrator.hpp"

namespace plant {

struct CraneState {
  CraneVector q{}, qd{};
  Joints torque{};     // motor side, N m, behind the current loop's lag
  double step = 1e-4;  // s, the integrator's first step
};

// The sway angles, as bits of CraneInputs::locked.
inline constexpr unsigned sway_coordinates = 1U << Q_ALPHA | 1U << Q_BETA;

// What is constant while the crane moves.
struct CraneInputs {
  Joints command{};                        // motor torque, N m
  std::array<bool, joint_count> braked{};  // brake closed and slipping
  unsigned locked = 0;                     // coordinates held at rest: brakes that hold, sway angles at L0 and L2
  Payload payload{};
  CraneVector external{};  // generalised forces other than the drives'
  std::array<std::int8_t, joint_count>
      sliding{};  // stiction: the direction in which dry friction is exact; 0: friction is smoothed
};

// A quantity that changes its sign at an event.
struct CraneRoot {
  enum class Kind : std::uint8_t { position, speed, sticking, tension } kind;
  std::size_t index = 0;  // coordinate; for sticking_force's magnitude, joint
  double level = 0.0;     // subtracted from the quantity
};

// Where energy went over an interval, J.
struct Work {
  double motors = 0.0;    // delivered at the motors' shafts
  double gears = 0.0;     // lost between shaft and joint; negative if the load drives the motor (plant-and-bus.md 1.3)
  double friction = 0.0;  // lost in the joints, slipping brakes included
  double damping = 0.0;   // lost by the sway
  double external = 0.0;  // done by CraneInputs::external
  double impacts = 0.0;   // lost in end stops and by closing brakes
  double stored() const {
    return motors - gears - friction - damping + external - impacts;
  }  // the growth of the crane's energy
  Work& operator+=(const Work& b) {
    motors += b.motors, gears += b.gears, friction += b.friction, damping += b.damping, external += b.external,
        impacts += b.impacts;
    return *this;
  }
};

class CraneMotion {
 public:
  CraneMotion(const CraneParameters&, const Integrator::Settings&);
  const Crane& crane() const { return crane_; }

  void advance(CraneState&, const CraneInputs&, double seconds);
  CraneVector acceleration(const CraneState&, const CraneInputs&) const;
  // Forces that the brakes of locked coordinates must hold, 0 for free ones.
  CraneVector holding_force(const CraneState&, const CraneInputs&) const;

  // The dry friction that keeps a locked joint at rest against its own motor and all other forces.
  double sticking_force(const CraneState&, const CraneInputs&, std::size_t joint) const;
  double sticking_force(const CraneVector& holding_force, const CraneState&, std::size_t joint) const;

  double value(const CraneRoot&, const CraneState&, const CraneInputs&) const;
  // Stops at the first root; returns the elapsed seconds, and in `which` the root or -1.
  double advance_to(CraneState&, const CraneInputs&, double seconds, std::span<const CraneRoot>, int& which);
  // The same as advance, with the work integrated as further states.
  Work advance_booked(CraneState&, const CraneInputs&, double seconds);
  // Steps of a fixed size (for tests of the order).
  void advance_fixed(CraneState&, const CraneInputs&, double seconds, double step);
  // Brings one coordinate to rest by an impulse there; the others feel it through the crane's inertia.
  void stop(CraneState&, const CraneInputs&, std::size_t coordinate) const;
  // CVODES' forward sensitivities: derivatives of (q, qd) after `seconds` by the payload's mass and by the rope's
  // length at the start.
  std::array<std::array<double, 2 * crane_size>, 2> sensitivity(const CraneState&, const CraneInputs&,
                                                                double seconds) const;

  // d (qd, qdd) / d (q, qd, torque), by central differences of fourth order; rows and columns of locked coordinates are
  // 0.
  using Slope = std::array<std::array<double, 2 * crane_size + joint_count>, 2 * crane_size>;
  Slope linearize(const CraneState&, const CraneInputs&) const;

  static constexpr std::size_t size = 2 * crane_size;  // integrated are q and qd; the torques' lag is solved exactly
  static constexpr std::size_t most_roots = 2 * joint_count + 4 + joint_count + 1;

 private:
  static constexpr std::size_t booked_size = size + 5;
  using Packed = std::array<double, size>;
  struct Known {
    CraneVector q, qd;
    Payload payload;
    Crane::Dynamics dynamics;
    Known(const Crane& crane, const CraneVector& at, const CraneVector& rate, const CraneInputs& in)
        : q(at), qd(rate), payload(in.payload), dynamics(crane.dynamics(at, rate, in.payload, in.locked)) {}
  };
  // exp of the last few exponents: steps of one length ask for the same ones again and again.
  class Decay {
   public:
    double operator()(double exponent);

   private:
    struct Known {
      double exponent = std::numeric_limits<double>::quiet_NaN(), value = 0.0;
    };
    std::array<Known, 4> known_{};
    std::size_t oldest_ = 0;
  };
  static void derivative(void* self, double t, const double* y, double* yd);
  static void booked_derivative(void* self, double t, const double* y, double* yd);
  static void root_values(void* self, double t, const double* y, double* values);
  static Packed pack(const CraneState&);
  static void unpack(std::span<const double>, CraneState&);
  void begin(const CraneState&, const CraneInputs&);
  Joints torque_at(double t) const;  // N m, t after the call's beginning
  // Remembers the last result: an interval begins where the one before ended, only its commands are new.
  const Crane::Dynamics& dynamics(const CraneVector& q, const CraneVector& qd, const CraneInputs&) const;
  CraneVector applied_force(const CraneVector& q, const CraneVector& qd, const Joints& torque, const CraneInputs&,
                            const Crane::Dynamics&) const;

  Crane crane_;
  Integrator::Settings settings_;
  Packed absolute_;
  Integrator integrator_;
  std::unique_ptr<Integrator> finder_, booker_;  // made when first needed
  const CraneInputs* inputs_ = nullptr;
  Joints torque_{};  // at the call's beginning
  mutable std::optional<Known> known_;
  mutable Decay decay_;
  std::span<const CraneRoot> roots_;
};

}  // namespace plant
