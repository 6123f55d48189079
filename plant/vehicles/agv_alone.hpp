#pragma once
// An AGV without a dock: set-points are given and held; there is no FIFO and no obstacle.
#include "plant/vehicles/agv.hpp"

namespace plant {

class AgvAlone {
 public:
  // Throws std::invalid_argument for an impossible vehicle, a pose that is not a number, a tolerance not within 1e-13
  // .. 1e-3.
  AgvAlone(const AgvParameters&, const Pose& start, double tolerance);

  // Advances by `seconds` (0 to 60; the drive's loop acts every 10 ms) with this set-point. Throws
  // std::invalid_argument.
  void step(const AgvSetPoint&, double seconds);
  // Its load, kg and kg m2 about the vertical. An added load was at rest, and momentum is conserved; a removed load has
  // the vehicle's speed, which does not change. Throws std::invalid_argument.
  void set_load(double mass, double inertia);
  void reset(const Pose&);

  // The complete state.
  struct State {
    AgvState vehicle;
    Time time{0};
    Time since_tick{0};  // of the drive's loop
  };
  const State& state() const { return state_; }
  void restore(const State& state) { state_ = state; }
  double energy() const;  // J, kinetic

 private:
  AgvParameters p_;
  AgvMotion motion_;
  State state_;
};

}  // namespace plant
