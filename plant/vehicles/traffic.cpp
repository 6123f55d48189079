#include "plant/vehicles/traffic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "plant/numerics/math.hpp"

namespace plant {
namespace {

// A vehicle at the point of contact: its velocity along the normal, and the change of this velocity by an impulse of 1
// N s.
struct Side {
  double speed, give;
};

struct Body {
  double mass, inertia, x, y, vx, vy, spin;
};

Body body_of(const AgvParameters& p, const AgvState& s) {
  const auto [sh, ch] = sin_cos(s.y[A_HEADING]);
  return {p.mass + s.load_mass,
          p.yaw_inertia + s.load_inertia,
          s.y[A_X],
          s.y[A_Y],
          s.y[A_SPEED] * ch - s.y[A_SIDE] * sh,
          s.y[A_SPEED] * sh + s.y[A_SIDE] * ch,
          s.y[A_YAW_RATE]};
}

double lever(const Body& b, const Touch& t) { return (t.x - b.x) * t.ny - (t.y - b.y) * t.nx; }

Side side_of(const Body& b, const Touch& t) {
  const double arm = lever(b, t);
  return {b.vx * t.nx + b.vy * t.ny + b.spin * arm, 1.0 / b.mass + arm * arm / b.inertia};
}

// Applies an impulse along the contact's normal; the bumper opens.
void push(const AgvParameters& p, AgvState& s, const Touch& t, double impulse) {
  const Body b = body_of(p, s);
  const auto [sh, ch] = sin_cos(s.y[A_HEADING]);
  const double vx = b.vx + impulse / b.mass * t.nx;
  const double vy = b.vy + impulse / b.mass * t.ny;
  s.y[A_SPEED] = vx * ch + vy * sh;
  s.y[A_SIDE] = -vx * sh + vy * ch;
  s.y[A_YAW_RATE] = b.spin + impulse * lever(b, t) / b.inertia;
  s.bumped = true;
  s.standing = s.running = s.dry = false;
  s.y[A_FORCE] = 0.0;
  s.waiting = 0;
  s.current = {};
}

}  // namespace

Solid Traffic::shape(const AgvState& s, std::size_t agv) const {
  return solid_of(config_.agv, static_cast<int>(agv), s.y[A_X], s.y[A_Y], s.y[A_HEADING]);
}

bool Traffic::impact(AgvState& agv, AgvState* other, const Solid& obstacle, const Touch& t, double& speed) const {
  const Side here = side_of(body_of(config_.agv, agv), t);
  Side there{obstacle.vx * t.nx + obstacle.vy * t.ny, 0.0};
  if (other != nullptr) there = side_of(body_of(config_.agv, *other), t);
  speed = there.speed - here.speed;
  const bool first = !agv.bumped || (other != nullptr && !other->bumped);
  if (speed > 0.0) {
    const double impulse = speed / (here.give + there.give);
    push(config_.agv, agv, t, impulse);
    if (other != nullptr) push(config_.agv, *other, t, -impulse);
  }
  // Moves both out of each other, each by its share.
  const double share = other == nullptr ? 1.0 : 0.5;
  agv.y[A_X] += share * t.depth * t.nx;
  agv.y[A_Y] += share * t.depth * t.ny;
  if (other != nullptr) {
    other->y[A_X] -= share * t.depth * t.nx;
    other->y[A_Y] -= share * t.depth * t.ny;
  }
  return first && speed > 0.0;
}

void Traffic::collide(std::vector<AgvState>& agvs, const std::vector<Solid>& solids, const Hear& hear) {
  for (std::size_t i = 0; i < agvs.size(); ++i) {
    for (const Solid& solid : solids) {
      const bool vehicle = solid.kind == Solid::Kind::agv;
      const auto j = static_cast<std::size_t>(solid.index);
      if (solid.kind == Solid::Kind::ground || (vehicle && j <= i)) continue;
      const auto t = geometry_.touch(shape(agvs[i], i), vehicle ? shape(agvs[j], j) : solid);
      if (!t) continue;
      double speed = 0.0;
      if (impact(agvs[i], vehicle ? &agvs[j] : nullptr, solid, *t, speed)) hear(i, vehicle ? solid.index : -1, speed);
    }
  }
}

Geometry::Scan Traffic::scan(const AgvState& agv, std::size_t number, const std::vector<Solid>& solids) {
  others_.clear();
  for (const Solid& solid : solids)
    if (solid.kind != Solid::Kind::agv || solid.index != static_cast<int>(number)) others_.push_back(solid);
  const auto [s, c] = sin_cos(agv.y[A_HEADING]);
  const double ahead = 0.5 * config_.agv.length;
  return geometry_.scan(agv.y[A_X] + ahead * c, agv.y[A_Y] + ahead * s, agv.y[A_HEADING], others_);
}

double Traffic::free_way(const AgvState& agv, const Geometry::Scan& scan) const {
  const AgvParameters& p = config_.agv;
  constexpr double beside = 0.3;  // m, free space required on either side
  const double front = 0.5 * p.length;
  const double half = 0.5 * p.width + beside;
  // The path of the vehicle's middle: a circle of this curvature, crabbing along the mean of its steering angles.
  const auto [sf, cf] = sin_cos(agv.y[A_FRONT]);
  const auto [sr, cr] = sin_cos(agv.y[A_REAR]);
  const bool steered = p.drive == AgvDrive::steered;
  const double crab = steered ? 0.5 * (agv.y[A_FRONT] + agv.y[A_REAR]) : 0.0;
  const double curvature = steered ? (sf / cf - sr / cr) / (p.front + p.rear) : 0.0;
  const auto [sc, cc] = sin_cos(crab);
  double free = std::numeric_limits<double>::infinity();
  for (std::size_t ray = 0; ray < scan.size(); ++ray) {
    if (scan[ray] >= range_most || scan[ray] == 0) continue;
    const double d = 1e-3 * scan[ray];
    const auto [s, c] = sin_cos(1e-6 * (range_first + static_cast<int>(ray) * range_step));
    const double px = front + d * c, py = d * s;
    const double along = cc * px + sc * py;
    const double across = -sc * px + cc * py;
    // The lane bends by curvature along^2 / 2; crabbing widens the swept area.
    const double aside = std::fabs(across - 0.5 * curvature * along * std::fabs(along));
    if (aside > half + std::fabs(sc) * front) continue;
    free = std::min(free, std::max(0.0, along - front));
  }
  return free;
}

double Traffic::allowed_speed(const AgvState& agv, const Geometry::Scan& scan) const {
  const AgvParameters& p = config_.agv;
  const double free = free_way(agv, scan);
  if (free == std::numeric_limits<double>::infinity()) return free;
  // v T + v^2 / 2b = free - margin; T is the time until the brakes act.
  const double lag = p.drive_lag + 0.1;
  const double room = std::max(0.0, free - p.protective_margin);
  const double b = p.braking;
  return -b * lag + std::sqrt(b * b * lag * lag + 2.0 * b * room);
}

}  // namespace plant
