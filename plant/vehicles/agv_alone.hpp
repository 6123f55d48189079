#pragma once
// An AGV without a dock: set-points are given and held, no FIFO, nothing to run into.
#include "plant/vehicles/agv.hpp"

namespace plant {

class AgvAlone {
 public:
  // Throws std::invalid_argument for a vehicle that cannot be, a pose that is no number, a tolerance not within 1e-13
  // .. 1e-3.
  AgvAlone(const AgvParameters&, const Pose& start, double tolerance);

  // Goes on for so many seconds (0 to 60; the drive's loop looks every 10 ms) with this set-point held. Throws
  // std::invalid_argument.
  void step(const AgvSetPoint&, double seconds);
  // What it carries, kg and kg m2 about the vertical. What is added was at rest, and the momentum is kept; what is
  // taken off has the vehicle's speed, which is kept. Throws std::invalid_argument.
  void set_load(double mass, double inertia);
  void reset(const Pose&);

  // Everything that its future depends on.
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
