#include "plant/scene.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "plant/math.hpp"
#include "plant/sensors.hpp"
#include "plant/state.hpp"

namespace plant {

Solid make_solid(Solid::Kind kind, int index, double x, double y, double yaw, double half_x, double half_y, double bottom,
                 double top) {
  const auto [s, c] = sin_cos(yaw);
  return {x, y, yaw, half_x, half_y, bottom, top, s, c, kind, index};
}

std::array<double, 3> ShipPlace::shift(const Box& ship, double x, double y, double z) const {
  const double dx = x - 0.5 * (ship.x_min + ship.x_max);
  const double dy = y - 0.5 * (ship.y_min + ship.y_max);
  return {surge + pitch * z, sway - roll * z, heave + roll * dy - pitch * dx};
}

ShipNow ship_at(const DockConfig& config, const std::vector<ContainerData>& containers, double seconds) {
  const ShipMotion& motion = config.ship;
  ShipNow now;
  if (!motion.moves()) return now;
  struct Row {
    double ShipPlace::*of;
    double size, period;  // m or rad, s
  };
  constexpr double degree = std::numbers::pi / 180.0;
  static constexpr std::array<Row, 5> rows = {{{&ShipPlace::surge, 0.2, 80.0},
                                               {&ShipPlace::sway, 0.1, 60.0},
                                               {&ShipPlace::heave, 0.1, 10.0},
                                               {&ShipPlace::roll, 0.5 * degree, 12.0},
                                               {&ShipPlace::pitch, 0.1 * degree, 8.0}}};
  static constexpr std::array<std::array<double, 2>, 3> parts = {{{0.6, 1.0}, {0.3, 0.83}, {0.1, 1.31}}};  // of size, of period
  constexpr int ship_axis = 16;  // keeps the phases apart from other noise
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const double size = motion.scale * rows[i].size * parts[k][0];
      const double rate = 2.0 * std::numbers::pi / (rows[i].period * parts[k][1]);
      const double phase = 2.0 * std::numbers::pi * noise(motion.seed, ship_axis + static_cast<int>(i), static_cast<std::int64_t>(k));
      const auto [s, c] = sin_cos(rate * seconds + phase);
      now.place.*rows[i].of += size * s;
      now.rate.*rows[i].of += size * rate * c;
    }
  double gone = 0.0;
  for (const ContainerData& c : containers)
    if (c.state != ContainerState::on_ship) gone += c.mass;
  now.place.heave += motion.draught * gone;
  return now;
}

ContainerData in_world(const ContainerData& c, const std::vector<AgvState>& agvs, const Box& ship, const ShipPlace& place) {
  if (c.state == ContainerState::on_ship) {
    const auto shift = place.shift(ship, c.x, c.y, c.z);
    ContainerData world = c;
    world.x += shift[0];
    world.y += shift[1];
    world.z += shift[2];
    return world;
  }
  if (c.state != ContainerState::on_agv) return c;
  const auto& y = agvs[static_cast<std::size_t>(c.agv)].y;
  const auto [s, co] = sin_cos(y[A_HEADING]);
  ContainerData world = c;
  world.x = y[A_X] + co * c.x - s * c.y;
  world.y = y[A_Y] + s * c.x + co * c.y;
  world.yaw = wrap_angle(y[A_HEADING] + c.yaw);
  return world;
}

void add_legs(const Portal& portal, double travel, double speed, std::vector<Solid>& solids) {
  if (portal.leg <= 0.0) return;
  const double half = 0.5 * portal.leg;
  for (const double along : {portal.along, -portal.along})
    for (const double y : {portal.waterside, portal.landside}) {
      solids.push_back(make_solid(Solid::Kind::crane, -1, travel + along, y, 0.0, half, half, 0.0, portal.height));
      solids.back().vx = speed;
    }
}

void collect_solids(const DockConfig& config, const DockState& state, int without, std::vector<Solid>& solids) {
  const std::vector<ContainerData>& containers = state.containers;
  const std::vector<AgvState>& agvs = state.agvs;
  const double seconds = state.seconds();
  solids.clear();
  const auto add_box = [&solids](Solid::Kind kind, const Box& b) {
    solids.push_back(make_solid(kind, -1, 0.5 * (b.x_min + b.x_max), 0.5 * (b.y_min + b.y_max), 0.0, 0.5 * (b.x_max - b.x_min),
                                0.5 * (b.y_max - b.y_min), b.z_min, b.z_max));
  };
  add_box(Solid::Kind::ground, {-500.0, 500.0, -500.0, 500.0, -5.0, 0.0});
  add_box(Solid::Kind::ship, config.layout.ship);
  const Box& ship = config.layout.ship;
  const ShipNow now = ship_at(config, containers, seconds);
  const auto ride = [&ship, &now](Solid& solid, double x, double y, double z) {
    const auto rate = now.rate.shift(ship, x, y, z);
    solid.vx = rate[0];
    solid.vy = rate[1];
    solid.vz = rate[2];
  };
  if (config.ship.moves()) {
    Solid& hull = solids.back();
    const double z = ship.z_max;
    const auto shift = now.place.shift(ship, hull.x, hull.y, z);
    ride(hull, hull.x, hull.y, z);
    hull.x += shift[0];
    hull.y += shift[1];
    hull.top += shift[2];
  }
  for (const Box& box : config.layout.no_go) add_box(Solid::Kind::fixed, box);
  add_legs(config.crane.portal, state.crane.q[Q_S], state.crane.qd[Q_S], solids);
  for (std::size_t i = 0; i < config.layout.movers.size(); ++i) {
    const Mover& mover = config.layout.movers[i];
    const MoverPlace at = place_of(mover, seconds);
    Solid solid = make_solid(Solid::Kind::mover, static_cast<int>(i), at.x, at.y, 0.0, mover.radius, mover.radius, 0.0, mover.height);
    solid.round = true;
    solid.vx = at.vx;
    solid.vy = at.vy;
    solids.push_back(solid);
  }
  for (std::size_t i = 0; i < agvs.size(); ++i) {
    const auto& y = agvs[i].y;
    const auto& p = config.agv;
    solids.push_back(make_solid(Solid::Kind::agv, static_cast<int>(i), y[A_X], y[A_Y], y[A_HEADING], 0.5 * p.length,
                                0.5 * p.width, 0.3, p.deck_height));
  }
  for (std::size_t i = 0; i < containers.size(); ++i) {
    const ContainerState where = containers[i].state;
    if (static_cast<int>(i) == without || where == ContainerState::carried || where == ContainerState::delivered) continue;
    const ContainerData c = in_world(containers[i], agvs, ship, now.place);
    solids.push_back(make_solid(Solid::Kind::container, static_cast<int>(i), c.x, c.y, c.yaw, 0.5 * container_length,
                                0.5 * container_width, c.z, c.z + container_height));
    if (where == ContainerState::on_ship) ride(solids.back(), containers[i].x, containers[i].y, containers[i].z);
  }
}

// Cubics between the waypoints that overshoot none of them (Fritsch and Butland's slopes, each axis for itself): where two successive waypoints are
// at one place the mover stands in between. At rest before the first and after the last.
MoverPlace place_of(const Mover& mover, double seconds) {
  const std::vector<Waypoint>& path = mover.path;
  const double first = path.front().time, last = path.back().time;
  double t = seconds;
  if (mover.repeats && last > first && t > first) t = first + std::fmod(t - first, last - first);
  if (t <= first || path.size() == 1) return {path.front().x, path.front().y, 0.0, 0.0};
  if (t >= last) return {path.back().x, path.back().y, 0.0, 0.0};
  std::size_t i = 0;
  while (path[i + 1].time <= t) ++i;
  const auto secant = [&](std::size_t k, double Waypoint::*axis) {
    return (path[k + 1].*axis - path[k].*axis) / (path[k + 1].time - path[k].time);
  };
  const auto slope = [&](std::size_t k, double Waypoint::*axis) {
    if (k == 0 || k + 1 == path.size()) return 0.0;
    const double before = secant(k - 1, axis), after = secant(k, axis);
    if (before * after <= 0.0) return 0.0;
    const double h0 = path[k].time - path[k - 1].time, h1 = path[k + 1].time - path[k].time;
    return 3.0 * (h0 + h1) / ((2.0 * h1 + h0) / before + (h1 + 2.0 * h0) / after);
  };
  const double h = path[i + 1].time - path[i].time;
  const double u = (t - path[i].time) / h, w = 1.0 - u;
  const auto value = [&](double Waypoint::*axis) {
    return path[i].*axis * (w * w * (1.0 + 2.0 * u)) + path[i + 1].*axis * (u * u * (3.0 - 2.0 * u)) +
           h * (slope(i, axis) * (u * w * w) - slope(i + 1, axis) * (u * u * w));
  };
  const auto rate = [&](double Waypoint::*axis) {
    return 6.0 * u * w * (path[i + 1].*axis - path[i].*axis) / h + slope(i, axis) * (w * w - 2.0 * u * w) +
           slope(i + 1, axis) * (u * u - 2.0 * u * w);
  };
  return {value(&Waypoint::x), value(&Waypoint::y), rate(&Waypoint::x), rate(&Waypoint::y)};
}

bool covers(const Solid& solid, double x, double y) {
  const double dx = x - solid.x;
  const double dy = y - solid.y;
  return std::fabs(solid.cos_yaw * dx + solid.sin_yaw * dy) <= solid.half_x &&
         std::fabs(-solid.sin_yaw * dx + solid.cos_yaw * dy) <= solid.half_y;
}

bool overlaps(const Solid& a, const Solid& b, double margin) {
  // Separating axes: the two sides of each rectangle.
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double c = std::fabs(a.cos_yaw * b.cos_yaw + a.sin_yaw * b.sin_yaw);
  const double s = std::fabs(a.cos_yaw * b.sin_yaw - a.sin_yaw * b.cos_yaw);
  const double ax = a.half_x + margin;
  const double ay = a.half_y + margin;
  if (std::fabs(a.cos_yaw * dx + a.sin_yaw * dy) > ax + c * b.half_x + s * b.half_y) return false;
  if (std::fabs(-a.sin_yaw * dx + a.cos_yaw * dy) > ay + s * b.half_x + c * b.half_y) return false;
  if (std::fabs(b.cos_yaw * dx + b.sin_yaw * dy) > b.half_x + c * ax + s * ay) return false;
  return std::fabs(-b.sin_yaw * dx + b.cos_yaw * dy) <= b.half_y + s * ax + c * ay;
}

namespace {

struct Stretch {
  double from, to, top;
};

// Where a line along x at `y` runs over the solid; from >= to when nowhere.
Stretch stretch_over(const Solid& solid, double y) {
  const double dy = y - solid.y;
  double from = -1e9, to = 1e9;
  const auto clip = [&](double slope, double at_centre, double half) {  // |slope (x - solid.x) + at_centre| <= half
    if (std::fabs(slope) < 1e-12) {
      if (std::fabs(at_centre) > half) to = from;
      return;
    }
    const double a = (-half - at_centre) / slope, b = (half - at_centre) / slope;
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  };
  clip(solid.cos_yaw, solid.sin_yaw * dy, solid.half_x);
  clip(-solid.sin_yaw, solid.cos_yaw * dy, solid.half_y);
  return {solid.x + from, solid.x + to, solid.top};
}

}  // namespace

double bay_height(const DockConfig& config, const std::vector<ContainerData>& containers, double seconds, double x_from, double x_to, double y) {
  const ShipPlace place = ship_at(config, containers, seconds).place;
  std::vector<Stretch> stretches;
  std::vector<double> ends = {x_from, x_to};
  for (const ContainerData& still : containers) {
    if (still.state != ContainerState::on_ship) continue;
    const ContainerData c = in_world(still, {}, config.layout.ship, place);
    const Stretch s = stretch_over(make_solid(Solid::Kind::container, -1, c.x, c.y, c.yaw, 0.5 * container_length,
                                              0.5 * container_width, c.z, c.z + container_height), y);
    if (s.from >= s.to || s.to <= x_from || s.from >= x_to) continue;
    stretches.push_back(s);
    for (const double end : {s.from, s.to})
      if (end > x_from && end < x_to) ends.push_back(end);
  }
  std::sort(ends.begin(), ends.end());
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const double middle = 0.5 * (ends[i] + ends[i + 1]);
    double top = config.layout.deck + place.shift(config.layout.ship, middle, y, config.layout.deck)[2];
    for (const Stretch& s : stretches)
      if (middle > s.from && middle < s.to) top = std::max(top, s.top);
    sum += top * (ends[i + 1] - ends[i]);
  }
  return sum / (x_to - x_from);
}

}  // namespace plant
