#include "plant/agv_alone.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "plant/check.hpp"

namespace plant {
namespace {

constexpr double tick = 0.01;    // s, the drive's loop
constexpr double piece = 1e-3;   // s
constexpr double longest_step = 60.0;  // s

}  // namespace

AgvAlone::AgvAlone(const AgvParameters& p, const Pose& start, double tolerance)
    : p_((check(p), p)),
      motion_((refuse(!(tolerance >= 1e-13 && tolerance <= 1e-3), "tolerance must be 1e-13 to 1e-3", tolerance), p), tolerance) {
  reset(start);
}

void AgvAlone::reset(const Pose& start) {
  for (const double x : {start.x, start.y, start.heading}) refuse(!std::isfinite(x), "a pose must be numbers", x);
  const double mass = state_.load_mass, inertia = state_.load_inertia;
  state_ = {};
  state_.load_mass = mass;
  state_.load_inertia = inertia;
  state_.y[A_X] = start.x;
  state_.y[A_Y] = start.y;
  state_.y[A_HEADING] = start.heading;
  time_ = since_tick_ = 0.0;
}

void AgvAlone::restore(const AgvState& state, double time) {
  state_ = state;
  time_ = time;
  since_tick_ = std::fmod(time, tick);
}

void AgvAlone::set_load(double mass, double inertia) {
  refuse(!(std::isfinite(mass) && mass >= 0.0), "a load must not be negative", mass);
  refuse(!(std::isfinite(inertia) && inertia >= 0.0), "the load's inertia must not be negative", inertia);
  const double m = (p_.mass + state_.load_mass) / (p_.mass + mass);
  state_.y[A_SPEED] *= m;
  state_.y[A_SIDE] *= m;
  state_.y[A_YAW_RATE] *= (p_.yaw_inertia + state_.load_inertia) / (p_.yaw_inertia + inertia);
  state_.load_mass = mass;
  state_.load_inertia = inertia;
}

void AgvAlone::step(const AgvSetPoint& point, double seconds) {
  refuse(!(seconds >= 0.0 && seconds <= longest_step), "a step must be 0 to 60 s", seconds);
  for (const double x : {point.speed, point.front, point.rear, point.turn}) refuse(!std::isfinite(x), "a set-point must be numbers", x);
  state_.current = {point.speed, std::clamp(point.front, -p_.steer_limit, p_.steer_limit),
                    std::clamp(point.rear, -p_.steer_limit, p_.steer_limit), point.turn};
  double left = seconds;
  while (left > 1e-12) {
    if (since_tick_ < 1e-12) motion_.drive_tick(state_, std::numeric_limits<double>::infinity());
    const double h = std::min({piece, left, tick - since_tick_});
    motion_.advance(state_, h);
    since_tick_ += h;
    if (since_tick_ > tick - 1e-12) since_tick_ = 0.0;
    left -= h;
  }
  time_ += seconds;
}

double AgvAlone::energy() const {
  const auto& y = state_.y;
  return 0.5 * (p_.mass + state_.load_mass) * (y[A_SPEED] * y[A_SPEED] + y[A_SIDE] * y[A_SIDE]) +
         0.5 * (p_.yaw_inertia + state_.load_inertia) * y[A_YAW_RATE] * y[A_YAW_RATE];
}

}  // namespace plant
