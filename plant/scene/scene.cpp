#include "plant/scene/scene.hpp"

#include <algorithm>
#include <cmath>

#include "plant/dock/state.hpp"
#include "plant/numerics/math.hpp"

namespace plant {

Solid make_solid(Solid::Kind kind, int index, double x, double y, double yaw, double half_x, double half_y,
                 double bottom, double top) {
  const auto [s, c] = yaw == 0.0 ? SinCos{yaw, 1.0} : sin_cos(yaw);  // most solids stand along the axes
  return {.x = x,
          .y = y,
          .yaw = yaw,
          .half_x = half_x,
          .half_y = half_y,
          .bottom = bottom,
          .top = top,
          .sin_yaw = s,
          .cos_yaw = c,
          .kind = kind,
          .index = index};
}

Solid solid_of(Solid::Kind kind, const Box& b) {
  return make_solid(kind, -1, 0.5 * (b.x_min + b.x_max), 0.5 * (b.y_min + b.y_max), 0.0, 0.5 * (b.x_max - b.x_min),
                    0.5 * (b.y_max - b.y_min), b.z_min, b.z_max);
}

Solid solid_of(const AgvParameters& p, int index, double x, double y, double heading) {
  const double underside = std::min(0.3, 0.5 * p.deck_height);  // m
  return make_solid(Solid::Kind::agv, index, x, y, heading, 0.5 * p.length, 0.5 * p.width, underside, p.deck_height);
}

double Solid::top_at(double px, double py) const {
  if (!tilted) return top;
  const Vector3 up = tilt.axis(2);
  return top - (up[0] * (px - x) + up[1] * (py - y)) / up[2];
}

Vector3 Solid::velocity_at(const Vector3& at) const {
  return Vector3{vx, vy, vz} + cross(spin, at - Vector3{x, y, top});
}

Vector3 Solid::middle() const {
  if (!tilted) return {x, y, 0.5 * (bottom + top)};
  return Vector3{x, y, top} - 0.5 * (top - bottom) * tilt.axis(2);
}

Frame Solid::frame() const {
  Frame f;
  f.axes << cos_yaw, -sin_yaw, 0.0, sin_yaw, cos_yaw, 0.0, 0.0, 0.0, 1.0;
  f.axes = tilt.axes * f.axes;
  return f;
}

namespace {

// An object on a moving ship; given at its place in calm water.
void ride(Solid& solid, const ShipPose& ship) {
  const Vector3 top = ship.at({solid.x, solid.y, solid.top});
  const Vector3 velocity = ship.velocity_at(top);
  solid.bottom += top[2] - solid.top;
  solid.x = top[0], solid.y = top[1], solid.top = top[2];
  solid.vx = velocity[0], solid.vy = velocity[1], solid.vz = velocity[2];
  solid.tilted = true;
  solid.tilt = ship.turn;
  solid.spin = ship.spin;
}

// A vehicle, or an object on one.
void ride(Solid& solid, const AgvState& agv) {
  const auto& y = agv.y;
  const auto [s, c] = sin_cos(y[A_HEADING]);
  solid.vx = y[A_SPEED] * c - y[A_SIDE] * s - y[A_YAW_RATE] * (solid.y - y[A_Y]);
  solid.vy = y[A_SPEED] * s + y[A_SIDE] * c + y[A_YAW_RATE] * (solid.x - y[A_X]);
  solid.spin = {0.0, 0.0, y[A_YAW_RATE]};
}

// A container's pose in the world; on the ship, in calm water.
ContainerData standing(const ContainerData& c, const std::vector<AgvState>& agvs) {
  if (c.state != ContainerState::on_agv) return c;
  const auto& y = agvs[static_cast<std::size_t>(c.agv)].y;
  const auto [s, co] = sin_cos(y[A_HEADING]);
  ContainerData world = c;
  world.x = y[A_X] + co * c.x - s * c.y;
  world.y = y[A_Y] + s * c.x + co * c.y;
  world.yaw = wrap_angle(y[A_HEADING] + c.yaw);
  return world;
}

}  // namespace

Solid solid_of(const ContainerData& container, int index, const std::vector<AgvState>& agvs, const ShipPose& ship) {
  const ContainerData c = standing(container, agvs);
  Solid solid = make_solid(Solid::Kind::container, index, c.x, c.y, c.yaw, 0.5 * container_length,
                           0.5 * container_width, c.z, c.z + container_height);
  if (c.state == ContainerState::on_ship && ship.moves) ride(solid, ship);
  if (c.state == ContainerState::on_agv) ride(solid, agvs[static_cast<std::size_t>(c.agv)]);
  return solid;
}

bool stands_on_ship(const Layout& layout, const ContainerPlace& place) {
  double under = 0.0;
  bool ship = false;
  const auto look = [&](const Solid& solid, const auto& rides) {
    if (solid.top >= place.z + 0.5 * container_height || !covers(solid, place.x, place.y) || solid.top <= under) return;
    under = solid.top;
    ship = rides();
  };
  look(solid_of(Solid::Kind::ship, layout.ship), [] { return true; });
  for (const Box& box : layout.no_go) look(solid_of(Solid::Kind::fixed, box), [] { return false; });
  for (const ContainerPlace& other : layout.containers)
    look(make_solid(Solid::Kind::container, -1, other.x, other.y, other.yaw, 0.5 * container_length,
                    0.5 * container_width, other.z, other.z + container_height),
         [&] { return stands_on_ship(layout, other); });
  return ship;
}

void each_leg(const Portal& portal, double travel, double speed, const VisitSolid& visit) {
  if (portal.leg <= 0.0) return;
  const double half = 0.5 * portal.leg;
  for (const double along : {portal.along, -portal.along})
    for (const double y : {portal.waterside, portal.landside}) {
      Solid leg = make_solid(Solid::Kind::crane, -1, travel + along, y, 0.0, half, half, 0.0, portal.height);
      leg.vx = speed;
      visit(leg);
    }
}

void collect_solids(const DockConfig& config, const DockState& state, int without, std::vector<Solid>& solids) {
  solids.clear();
  each_solid(config, state, without, [&solids](const Solid& solid) { solids.push_back(solid); });
}

void each_solid(const DockConfig& config, const DockState& state, int without, const VisitSolid& visit) {
  const std::vector<ContainerData>& containers = state.containers;
  const std::vector<AgvState>& agvs = state.agvs;
  const double seconds = state.seconds();
  visit(solid_of(Solid::Kind::ground, {-500.0, 500.0, -500.0, 500.0, -5.0, 0.0}));
  const ShipPose ship = ship_at(config, containers, seconds);
  Solid hull = solid_of(Solid::Kind::ship, config.layout.ship);
  if (ship.moves) ride(hull, ship);
  visit(hull);
  for (const Box& box : config.layout.no_go) visit(solid_of(Solid::Kind::fixed, box));
  each_leg(config.crane.portal, state.crane.q[Q_S], state.crane.qd[Q_S], visit);
  for (std::size_t i = 0; i < config.layout.movers.size(); ++i) {
    const Mover& mover = config.layout.movers[i];
    const MoverPlace at = place_of(mover, seconds);
    Solid solid = make_solid(Solid::Kind::mover, static_cast<int>(i), at.x, at.y, 0.0, mover.radius, mover.radius, 0.0,
                             mover.height);
    solid.round = true;
    solid.vx = at.vx;
    solid.vy = at.vy;
    visit(solid);
  }
  for (std::size_t i = 0; i < agvs.size(); ++i) {
    const auto& y = agvs[i].y;
    Solid agv = solid_of(config.agv, static_cast<int>(i), y[A_X], y[A_Y], y[A_HEADING]);
    ride(agv, agvs[i]);
    visit(agv);
  }
  for (std::size_t i = 0; i < containers.size(); ++i) {
    const ContainerState where = containers[i].state;
    if (static_cast<int>(i) == without || where == ContainerState::carried || where == ContainerState::delivered)
      continue;
    visit(solid_of(containers[i], static_cast<int>(i), agvs, ship));
  }
}

// Cubics between the waypoints without overshoot (Fritsch and Butland's slopes, each axis separately). Between two
// successive waypoints at one place the mover stands. At rest before the first and after the last one.
MoverPlace place_of(const Mover& mover, double seconds) {
  const std::vector<Waypoint>& path = mover.path;
  const double first = path.front().time, last = path.back().time;
  double t = seconds;
  if (mover.repeats && last > first && t > first) t = first + std::fmod(t - first, last - first);
  if (t <= first || path.size() == 1) return {path.front().x, path.front().y, 0.0, 0.0};
  if (t >= last) return {path.back().x, path.back().y, 0.0, 0.0};
  std::size_t i = 0;
  while (path[i + 1].time <= t) ++i;
  const auto secant = [&](std::size_t k, double Waypoint::* axis) {
    return (path[k + 1].*axis - path[k].*axis) / (path[k + 1].time - path[k].time);
  };
  const auto slope = [&](std::size_t k, double Waypoint::* axis) {
    if (k == 0 || k + 1 == path.size()) return 0.0;
    const double before = secant(k - 1, axis), after = secant(k, axis);
    if (before * after <= 0.0) return 0.0;
    const double h0 = path[k].time - path[k - 1].time, h1 = path[k + 1].time - path[k].time;
    return 3.0 * (h0 + h1) / ((2.0 * h1 + h0) / before + (h1 + 2.0 * h0) / after);
  };
  const double h = path[i + 1].time - path[i].time;
  const double u = (t - path[i].time) / h, w = 1.0 - u;
  const auto value = [&](double Waypoint::* axis) {
    return path[i].*axis * (w * w * (1.0 + 2.0 * u)) + path[i + 1].*axis * (u * u * (3.0 - 2.0 * u)) +
           h * (slope(i, axis) * (u * w * w) - slope(i + 1, axis) * (u * u * w));
  };
  const auto rate = [&](double Waypoint::* axis) {
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

struct Interval {
  double from, to;
  Solid solid;
};

// The part of a line along x at `y` that lies over the solid; from >= to if there is none.
Interval interval_over(const Solid& solid, double y) {
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
  return {solid.x + from, solid.x + to, solid};
}

}  // namespace

double bay_height(const DockConfig& config, const DockState& state, double x_from, double x_to, double y) {
  const ShipPose ship = ship_at(config, state.containers, state.seconds());
  Solid deck = make_solid(Solid::Kind::ship, -1, 0.0, y, 0.0, 0.0, 0.0, 0.0, config.layout.deck);
  if (ship.moves) ride(deck, ship);
  std::vector<Interval> intervals;
  std::vector<double> ends = {x_from, x_to};
  for (const ContainerData& container : state.containers) {
    if (container.state != ContainerState::on_ship) continue;
    const Interval s = interval_over(solid_of(container, -1, state.agvs, ship), y);
    if (s.from >= s.to || s.to <= x_from || s.from >= x_to) continue;
    intervals.push_back(s);
    for (const double end : {s.from, s.to})
      if (end > x_from && end < x_to) ends.push_back(end);
  }
  std::sort(ends.begin(), ends.end());
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const double middle = 0.5 * (ends[i] + ends[i + 1]);
    double top = deck.top_at(middle, y);
    for (const Interval& s : intervals)
      if (middle > s.from && middle < s.to) top = std::max(top, s.solid.top_at(middle, y));
    sum += top * (ends[i + 1] - ends[i]);
  }
  return sum / (x_to - x_from);
}

}  // namespace plant
