#include "plant/parameters/config.hpp"

#include <algorithm>
#include <cmath>

#include "plant/numerics/math.hpp"

namespace plant {
namespace {

constexpr double turn_radius = 12.0;                       // m
constexpr double curve_speed = 3.0, straight_speed = 5.0;  // m/s

}  // namespace

// Five forward segments make the loop: along the quay past the spot, round, back past the warehouse, round.
std::array<std::vector<LaneSegment>, 3> default_loop(const Layout& layout, int agvs) {
  const double half_turn = std::numbers::pi * turn_radius;
  const double right = std::max(layout.spot.x + 20.0, layout.warehouse.x);
  const double left = std::min({-8.0, layout.spot.x - layout.slot_spacing * agvs - 8.0, layout.warehouse.x});
  const double near = layout.spot.y;
  const double far = near - 2.0 * turn_radius;
  const double west = std::numbers::pi;
  const std::vector<LaneSegment> out = {
      {layout.spot.x, near, 0.0, right - layout.spot.x, 0.0, straight_speed},
      {right, near, 0.0, half_turn, -1.0 / turn_radius, curve_speed},
      {right, far, west, right - layout.warehouse.x, 0.0, straight_speed},
  };
  const std::vector<LaneSegment> back = {
      {layout.warehouse.x, far, west, layout.warehouse.x - left, 0.0, straight_speed},
      {left, far, west, half_turn, -1.0 / turn_radius, curve_speed},
      {left, near, 0.0, layout.spot.x - left, 0.0, straight_speed},
  };
  return {out, back, back};
}

std::array<JointName, joint_count> joint_names(CraneKind machine) {
  if (machine == CraneKind::gantry)
    return {{{"s", "m"}, {"psi", "rad"}, {"trolley", "m"}, {"l", "m"}, {"kappa", "rad"}}};
  return {{{"s", "m"}, {"psi", "rad"}, {"phi", "rad"}, {"l", "m"}, {"kappa", "rad"}}};
}

std::array<int, joint_count> drive_channels(CraneKind machine) {
  if (machine == CraneKind::gantry) return {1, 0, 2, 3, 4};
  return {0, 1, 2, 3, 4};
}

CraneParameters gantry_crane() {
  CraneParameters p;
  p.machine = CraneKind::gantry;
  p.portal = {.along = 9.0, .landside = -18.0, .waterside = 0.0, .leg = 1.2, .height = 36.0};
  p.pivot_height = 34.0;
  p.gantry_mass = 900e3;
  p.jib_mass = 25e3;
  p.counterweight = 0.0;
  p.lower = {-200.0, 0.0, -33.0, 3.0, -6.2831853071795862};
  p.upper = {200.0, 3.1415926535897931, 38.5, 49.0, 6.2831853071795862};
  p.drives[0] = {.rated_torque = 1146.0, .gear = 209.0, .rotor_inertia = 1.2};  // 12 x 15 kW: 0.75 m/s
  p.drives[2] = {.rated_torque = 1019.0, .gear = 62.8, .rotor_inertia = 2.0};   // 4 x 40 kW: 2.5 m/s
  return p;
}

DockConfig default_dock(int agv_count) {
  DockConfig config;
  config.agv_count = agv_count;
  Layout& layout = config.layout;
  const double upper = layout.deck + container_height;
  layout.containers = {
      {0.0, 24.0, layout.deck, 0.0, 24e3}, {12.7, 24.0, layout.deck, 0.0, 20e3}, {-12.7, 24.0, layout.deck, 0.0, 26e3},
      {0.0, 26.6, layout.deck, 0.0, 22e3}, {12.7, 26.6, layout.deck, 0.0, 18e3}, {-12.7, 26.6, layout.deck, 0.0, 25e3},
      {0.0, 24.0, upper, 0.0, 21e3},       {-12.7, 26.6, upper, 0.0, 16e3},
  };
  layout.no_go = {{-34.0, -24.0, 20.0, 34.0, 0.0, 25.0}};  // the ship's deck-house
  layout.legs = default_loop(layout, agv_count);
  return config;
}

DockConfig gantry_dock(int agv_count) {
  DockConfig config = default_dock(agv_count);
  config.crane = gantry_crane();
  config.home = {0.0, 0.0, -8.0, 14.0, 0.0};
  Layout& layout = config.layout;
  layout.rows = {10.0, 12.6, 15.2, 17.8};
  layout.ship.y_min = 6.0;
  layout.ship.y_max = 22.0;
  const double upper = layout.deck + container_height;
  layout.containers = {
      {0.0, 10.0, layout.deck, 0.0, 24e3}, {0.0, 12.6, layout.deck, 0.0, 20e3},  {0.0, 15.2, layout.deck, 0.0, 26e3},
      {0.0, 17.8, layout.deck, 0.0, 22e3}, {12.7, 10.0, layout.deck, 0.0, 18e3}, {-12.7, 12.6, layout.deck, 0.0, 25e3},
      {0.0, 12.6, upper, 0.0, 21e3},       {0.0, 15.2, upper, 0.0, 16e3},
  };
  layout.no_go = {{-34.0, -24.0, 6.0, 20.0, 0.0, 25.0}};
  layout.spot = {0.0, -8.0, 0.0};
  layout.warehouse = {-12.0, -32.0, std::numbers::pi};
  layout.legs = default_loop(layout, agv_count);
  return config;
}

Pose along(const LaneSegment& s, double way) {
  const double heading = s.heading + s.curvature * way;
  const auto [sh, ch] = sin_cos(s.heading);
  if (s.curvature == 0.0) return {s.x + way * ch, s.y + way * sh, s.heading};
  const auto [st, ct] = sin_cos(heading);
  return {s.x + (st - sh) / s.curvature, s.y - (ct - ch) / s.curvature, heading};
}

double distance_from(const LaneSegment& lane, double x, double y) {
  const double dx = x - lane.x, dy = y - lane.y;
  const double c = cos(lane.heading), s = sin(lane.heading);
  const double along = dx * c + dy * s, across = dy * c - dx * s;
  if (lane.curvature == 0) {
    const double beyond = along < 0 ? -along : std::max(0.0, along - lane.length);
    return hypot(across, beyond);
  }
  // Mirrored, so that the arc turns left: its centre is at (0, radius).
  const double radius = 1 / std::abs(lane.curvature);
  const double left = lane.curvature > 0 ? across : -across;
  double angle = atan2(along, radius - left);
  if (angle < -1e-6) angle += 2 * std::numbers::pi;
  if (angle * radius > lane.length + 1e-6) return 1e9;
  return std::abs(hypot(along, radius - left) - radius);
}

Pose start_of_agv(const Layout& layout, int i) {
  const auto [s, c] = sin_cos(layout.spot.heading);
  const double back = layout.slot_spacing * i;
  return {layout.spot.x - c * back, layout.spot.y - s * back, wrap_angle(layout.spot.heading)};
}

}  // namespace plant
