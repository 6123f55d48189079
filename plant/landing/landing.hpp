#pragma once
// The payload near contact (plant-and-bus.md 1.3 level L2, 1.5, 1.6): below a small clearance it becomes a rigid body
// in ODE that hangs from the tip on four elastic one-sided falls; well clear of everything it becomes the ideal
// pendulum again.
#include <vector>

#include "plant/dock/state.hpp"

namespace plant {

class Landing {
 public:
  explicit Landing(const DockConfig&);

  // The present payload: the spreader, and the container that it carries.
  Payload payload(const DockState&) const;
  // Smallest height of the payload over anything that it could touch, m; large when far above everything.
  double clearance(const DockState&, const Crane&);

  // Hand-overs. Both keep the positions, the linear momentum and the momentum of every joint; they return the energy's
  // jump, J.
  double begin(DockState&, const CraneMotion&);
  double end(DockState&, const Crane&);

  struct Outcome {
    bool touched = false;                     // first contact in this step
    double vertical = 0.0, horizontal = 0.0;  // m/s just before it
    bool clear = false;                       // it could be handed back
  };
  // One exchange at the present latch: forces of falls, rotator, guides and wind (N, world) from both sides as they are
  // now; moves the body on by `seconds` and leaves in state.inputs what the crane feels meanwhile. Also reads the
  // corner switches, as they are now.
  Outcome step(DockState&, const Crane&, const Vector3& wind, double seconds);
  // 0.25 ms in or near contact, else 0.5 ms, on the 0.5-ms grid.
  int latches_per_step(const DockState&, const Crane&);

  // Twist locks: takes what the corners sit on (returns its number or -1), or lets go of what hangs there (the number,
  // or -1).
  int take(DockState&);
  int release(DockState&);
  // Whether what hangs there stays where it is let go: not on a vehicle's load, a mover or a crane's leg.
  bool may_release(const DockState&);

  std::array<double, 3> payload_position(const DockState&) const;  // of the body: middle of the spreader's underside
  double payload_yaw(const DockState&) const;
  double energy(const DockState&, const Crane&) const;  // J, crane and body and falls
  // How far the payload is from where it should land: metres between the middles, radians; nothing below: zeros.
  std::array<double, 2> landing_error(const DockState&);

 private:
  struct Forces {
    std::array<double, 3> force{}, torque{};
    CraneVector crane{};
    double tension = 0.0;
    bool taut = true;
  };
  BodyShape shape(const DockState&) const;
  void add_falls(const DockState&, const Crane&, double seconds, Forces&) const;
  void add_guides(const DockState&, Forces&) const;
  void read_corners(DockState&) const;
  Solid footprint(const DockState&, double x, double y, double z, double yaw) const;
  Solid around(const DockState&) const;
  static double highest_under(const Solid& foot, const Solid&);
  double clearance_of(const DockState&, const Solid& foot);
  const Solid* support(double x, double y, double z) const;
  std::array<double, 3> carried_at(const DockState&) const;  // middle of the container's underside; upright
  void find_near(const DockState&);

  DockConfig config_;
  LandingParameters p_;
  ContactEngine engine_;
  std::vector<Solid> near_;  // scratch, rebuilt at each use
};

}  // namespace plant
