#include "plant/vehicles/agv_alone.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "plant/parameters/check.hpp"

namespace plant {
namespace {

constexpr Time tick{10'000'000'000};  // the drive's loop
constexpr Time piece{1'000'000'000};
constexpr double longest_step = 60.0;  // s

}  // namespace

AgvAlone::AgvAlone(const AgvParameters& p, const Pose& start, double tolerance)
    : p_((check(p), p)),
      motion_((refuse(!(tolerance >= 1e-13 && tolerance <= 1e-3), "tolerance must be 1e-13 to 1e-3", tolerance), p),
              tolerance) {
  reset(start);
}

void AgvAlone::reset(const Pose& start) {
  for (const double x : {start.x, start.y, start.heading}) refuse(!std::isfinite(x), "a pose must be numbers", x);
  AgvState vehicle;
  vehicle.load_mass = state_.vehicle.load_mass;
  vehicle.load_inertia = state_.vehicle.load_inertia;
  vehicle.y[A_X] = start.x;
  vehicle.y[A_Y] = start.y;
  vehicle.y[A_HEADING] = start.heading;
  state_ = {vehicle};
}

void AgvAlone::set_load(double mass, double inertia) {
  refuse(!(std::isfinite(mass) && mass >= 0.0), "a load must not be negative", mass);
  refuse(!(std::isfinite(inertia) && inertia >= 0.0), "the load's inertia must not be negative", inertia);
  change_load(state_.vehicle, p_, mass, inertia, {0.0, 0.0, 0.0});
}

void AgvAlone::step(const AgvSetPoint& point, double seconds) {
  refuse(!(seconds >= 0.0 && seconds <= longest_step), "a step must be 0 to 60 s", seconds);
  for (const double x : {point.speed, point.front, point.rear, point.turn})
    refuse(!std::isfinite(x), "a set-point must be numbers", x);
  state_.vehicle.current = {point.speed, std::clamp(point.front, -p_.steer_limit, p_.steer_limit),
                            std::clamp(point.rear, -p_.steer_limit, p_.steer_limit), point.turn};
  const Time end = state_.time + Time{std::llround(seconds * 1e12)};
  while (state_.time < end) {
    if (state_.since_tick == Time{0}) motion_.drive_tick(state_.vehicle, std::numeric_limits<double>::infinity());
    const Time h = std::min({piece, end - state_.time, tick - state_.since_tick});
    motion_.advance(state_.vehicle, static_cast<double>(h.count()) * 1e-12);
    state_.since_tick = state_.since_tick + h == tick ? Time{0} : state_.since_tick + h;
    state_.time += h;
  }
}

double AgvAlone::energy() const {
  const auto& y = state_.vehicle.y;
  return 0.5 * (p_.mass + state_.vehicle.load_mass) * (y[A_SPEED] * y[A_SPEED] + y[A_SIDE] * y[A_SIDE]) +
         0.5 * (p_.yaw_inertia + state_.vehicle.load_inertia) * y[A_YAW_RATE] * y[A_YAW_RATE];
}

}  // namespace plant
