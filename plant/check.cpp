#include "plant/check.hpp"

#include <fmt/format.h>

#include <cmath>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <vector>

#include "plant/crane.hpp"
#include "plant/math.hpp"
#include "plant/scene.hpp"

namespace plant {
namespace {

struct Named {
  const char* name;
  double value;
};

void require_positive(std::initializer_list<Named> values) {
  for (const auto& [name, value] : values)
    if (!std::isfinite(value) || value <= 0.0)
      throw std::invalid_argument(fmt::format("plant: {} must be positive (got {})", name, value));
}

void require_not_negative(std::initializer_list<Named> values) {
  for (const auto& [name, value] : values)
    if (!std::isfinite(value) || value < 0.0)
      throw std::invalid_argument(fmt::format("plant: {} must not be negative (got {})", name, value));
}

void check(const LandingParameters& p) {
  require_positive({{"fall_stiffness", p.fall_stiffness}, {"corner_stiffness", p.corner_stiffness}, {"landing's near", p.near},
                    {"guide_window", p.guide_window}, {"guide_height", p.guide_height}, {"seat_error", p.seat_error},
                    {"seat_gap", p.seat_gap}});
  require_not_negative({{"fall_damping", p.fall_damping}, {"fall_spread_x", p.fall_spread_x}, {"fall_spread_y", p.fall_spread_y},
                        {"yaw_stiffness", p.yaw_stiffness}, {"yaw_damping", p.yaw_damping}, {"corner_damping", p.corner_damping},
                        {"friction", p.friction}, {"guide_stiffness", p.guide_stiffness}, {"guide_damping", p.guide_damping},
                        {"touch_speed", p.touch_speed}, {"touch_sway", p.touch_sway}, {"lock_time", p.lock_time}});
  refuse(!(p.away > p.near), "landing's away must be more than its near", p.away);
}

void check(const Box& b, const std::string& name) {
  const bool ordered = b.x_min < b.x_max && b.y_min < b.y_max && b.z_min < b.z_max;
  if (!ordered) throw std::invalid_argument(fmt::format("plant: {} needs min < max along x, y and z", name));
}

struct Thing {
  std::string name;
  Solid solid;
};

// The crane's legs at the start.
std::vector<Solid> legs_of(const DockConfig& c) {
  std::vector<Solid> legs;
  add_legs(c.crane.portal, c.home.s, 0.0, legs);
  return legs;
}

// Everything that stands on the dock at the start and must stand apart.
std::vector<Thing> things(const DockConfig& c) {
  std::vector<Thing> all;
  for (std::size_t i = 0; i < c.layout.no_go.size(); ++i) {
    const Box& b = c.layout.no_go[i];
    all.push_back({fmt::format("box {}", i),
                   make_solid(Solid::Kind::fixed, -1, 0.5 * (b.x_min + b.x_max), 0.5 * (b.y_min + b.y_max), 0.0,
                              0.5 * (b.x_max - b.x_min), 0.5 * (b.y_max - b.y_min), b.z_min, b.z_max)});
  }
  for (std::size_t i = 0; i < c.layout.containers.size(); ++i) {
    const ContainerPlace& p = c.layout.containers[i];
    all.push_back({fmt::format("container {}", i), make_solid(Solid::Kind::container, -1, p.x, p.y, p.yaw, 0.5 * container_length,
                                                              0.5 * container_width, p.z, p.z + container_height)});
  }
  for (std::size_t i = 0; i < c.layout.movers.size(); ++i) {
    const Mover& m = c.layout.movers[i];
    all.push_back({fmt::format("mover {}", i), make_solid(Solid::Kind::mover, -1, m.path.front().x, m.path.front().y, 0.0, m.radius,
                                                          m.radius, 0.0, m.height)});
  }
  for (int i = 0; i < c.agv_count; ++i) {
    const Pose at = start_of_agv(c.layout, i);
    all.push_back({fmt::format("AGV {}", i), make_solid(Solid::Kind::agv, i, at.x, at.y, at.heading, 0.5 * c.agv.length,
                                                        0.5 * c.agv.width, 0.3, c.agv.deck_height)});
  }
  const std::vector<Solid> legs = legs_of(c);
  for (std::size_t i = 0; i < legs.size(); ++i) all.push_back({fmt::format("the crane's leg {}", i), legs[i]});
  return all;
}

// A vehicle that keeps to its lane must not run into the crane where that stands at the start.
void check_lanes(const DockConfig& c) {
  constexpr double sampled = 0.5;  // m
  const std::vector<Solid> legs = legs_of(c);
  for (const auto& lane : c.layout.legs)
    for (const LaneSegment& s : lane) {
      refuse(!(s.length >= 0.0 && s.length <= 1e5), "a lane's length must be 0 to 1e5 m", s.length);
      for (int i = 0; i * sampled <= s.length; ++i) {
        const Pose at = along(s, i * sampled);
        const Solid vehicle = make_solid(Solid::Kind::agv, -1, at.x, at.y, at.heading, 0.5 * c.agv.length, 0.5 * c.agv.width, 0.0, c.agv.deck_height);
        for (const Solid& leg : legs)
          if (overlaps(vehicle, leg, 0.0))
            throw std::invalid_argument(fmt::format("plant: an AGV at ({:.2f}, {:.2f}) m of its lane runs into the crane's leg at ({:.2f}, {:.2f}) m; "
                                                    "move the lane or the crane's portal", at.x, at.y, leg.x, leg.y));
      }
    }
}

void check_apart(const DockConfig& c) {
  constexpr double play = 1e-3;  // m, by which neighbours may overlap in a layout's rounded numbers
  const std::vector<Thing> all = things(c);
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      const Solid& a = all[i].solid;
      const Solid& b = all[j].solid;
      if (std::min(a.top, b.top) - std::max(a.bottom, b.bottom) <= play || !overlaps(a, b, -play)) continue;
      throw std::invalid_argument(fmt::format("plant: {} and {} are inside each other, at ({:.2f}, {:.2f}) and ({:.2f}, {:.2f}) m",
                                              all[i].name, all[j].name, a.x, a.y, b.x, b.y));
    }
}

void check_reach(const DockConfig& c) {
  const auto reach = [&c](const std::string& what, double x, double y, double z) {
    try {
      inverse_kinematics(c.crane, {c.home.s, x, y, z, c.home.yaw});
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("{}; so the crane cannot reach {}", error.what(), what));
    }
  };
  reach("its home", c.home.x, c.home.y, c.home.z);
  for (std::size_t i = 0; i < c.layout.containers.size(); ++i) {
    const ContainerPlace& p = c.layout.containers[i];
    reach(fmt::format("container {}", i), p.x, p.y, p.z + container_height);
  }
  if (c.agv_count > 0) reach("the loading spot", c.layout.spot.x, c.layout.spot.y, c.agv.deck_height);
}

// Each container stands on something, and the spreader hangs at home with nothing inside it.
void check_standing(const DockConfig& c) {
  constexpr double play = 0.02;  // m
  std::vector<Thing> all = things(c);
  const Box& ship = c.layout.ship;
  all.push_back({"the ship", make_solid(Solid::Kind::ship, -1, 0.5 * (ship.x_min + ship.x_max), 0.5 * (ship.y_min + ship.y_max), 0.0,
                                        0.5 * (ship.x_max - ship.x_min), 0.5 * (ship.y_max - ship.y_min), ship.z_min, ship.z_max)});
  for (std::size_t i = 0; i < c.layout.containers.size(); ++i) {
    const ContainerPlace& p = c.layout.containers[i];
    double under = 0.0;
    for (const Thing& thing : all)
      if (covers(thing.solid, p.x, p.y) && (thing.solid.kind == Solid::Kind::ship || thing.solid.top < p.z + 0.5 * container_height)) under = std::max(under, thing.solid.top);
    if (!(std::fabs(p.z - under) <= play))
      throw std::invalid_argument(fmt::format("plant: container {} must stand on something: its underside is at {:.3f} m, what is below it ends at {:.3f} m", i,
                                              p.z, under));
  }
  const Solid spreader = make_solid(Solid::Kind::fixed, -1, c.home.x, c.home.y, c.home.yaw, 0.5 * container_length, 0.5 * container_width, c.home.z, c.home.z + 1.0);
  refuse(c.home.z < 0.0, "the spreader's home must be above the ground", c.home.z);
  for (const Thing& thing : all)
    if (std::min(thing.solid.top, spreader.top) - std::max(thing.solid.bottom, spreader.bottom) > play && overlaps(thing.solid, spreader, -play))
      throw std::invalid_argument(fmt::format("plant: the spreader's home at ({:.2f}, {:.2f}, {:.2f}) m is inside {}", c.home.x, c.home.y, c.home.z, thing.name));
}

void check_containers(const DockConfig& c) {
  for (std::size_t i = 0; i < c.layout.containers.size(); ++i) {
    const ContainerPlace& p = c.layout.containers[i];
    if (!std::isfinite(p.x + p.y + p.z + p.yaw))
      throw std::invalid_argument(fmt::format("plant: container {} needs a place of numbers", i));
    if (!(p.mass > 0.0))
      throw std::invalid_argument(fmt::format("plant: container {}'s mass must be positive (got {})", i, p.mass));
    if (p.mass > c.rated_load)
      throw std::invalid_argument(
          fmt::format("plant: container {} weighs {} kg, more than the crane's rated_load of {} kg", i, p.mass, c.rated_load));
  }
}

}  // namespace

void refuse(bool bad, const char* what, double value) {
  if (bad) throw std::invalid_argument(fmt::format("plant: {} (got {})", what, value));
}

void check(const AgvParameters& p) {
  require_positive({{"an AGV's mass", p.mass}, {"an AGV's length", p.length}, {"an AGV's width", p.width}, {"an AGV's front", p.front},
                    {"an AGV's rear", p.rear}, {"an AGV's yaw_inertia", p.yaw_inertia}, {"an AGV's deck_height", p.deck_height},
                    {"an AGV's cornering", p.cornering}, {"an AGV's adhesion", p.adhesion}, {"an AGV's steer_rate", p.steer_rate},
                    {"an AGV's steer_lag", p.steer_lag}, {"an AGV's drive_lag", p.drive_lag}, {"an AGV's acceleration", p.acceleration},
                    {"an AGV's braking", p.braking}, {"an AGV's emergency", p.emergency}, {"an AGV's blend_speed", p.blend_speed},
                    {"an AGV's track", p.track}, {"an AGV's wheel_slip", p.wheel_slip}});
  require_not_negative({{"an AGV's rolling", p.rolling}, {"an AGV's drag", p.drag}, {"an AGV's speed_gain", p.speed_gain},
                        {"an AGV's speed_integral", p.speed_integral},
                        {"an AGV's protective_margin", p.protective_margin}});
  refuse(!(p.steer_limit > 0.0 && p.steer_limit < 1.5), "an AGV's steer_limit must be above 0 and below 1.5 rad", p.steer_limit);
}

void check(const CraneParameters& p) {
  require_positive({{"jib", p.jib}, {"pivot_height", p.pivot_height}, {"gantry_mass", p.gantry_mass}, {"slew_inertia", p.slew_inertia},
                    {"jib_mass", p.jib_mass}, {"jib_inertia", p.jib_inertia}, {"spreader_mass", p.spreader_mass},
                    {"spreader_inertia", p.spreader_inertia}});
  require_not_negative({{"a0", p.a0}, {"jib_centre", p.jib_centre}, {"counterweight", p.counterweight},
                        {"counterweight_radius", p.counterweight_radius}, {"sway_damping", p.sway_damping}});
  for (const DriveParameters& d : p.drives) {
    require_positive({{"a drive's rated_torque", d.rated_torque}, {"a drive's rated_speed", d.rated_speed}, {"a drive's gear", d.gear},
                      {"a drive's torque_lag", d.torque_lag}, {"a drive's smooth_speed", d.smooth_speed},
                      {"a drive's stribeck_speed", d.stribeck_speed}});
    require_not_negative({{"a drive's rotor_inertia", d.rotor_inertia}, {"a drive's coulomb", d.coulomb},
                          {"a drive's stribeck", d.stribeck}, {"a drive's viscous", d.viscous}, {"a drive's brake", d.brake}});
    refuse(!(d.efficiency > 0.0 && d.efficiency <= 1.0), "a drive's efficiency must be above 0 and at most 1", d.efficiency);
  }
  for (std::size_t j = 0; j < joint_count; ++j)
    refuse(!(p.lower[j] < p.upper[j]), "a joint's lower limit must be below its upper one", p.lower[j]);
  require_not_negative({{"the portal's leg", p.portal.leg}});
  require_positive({{"the portal's along", p.portal.along}, {"the portal's height", p.portal.height}});
  refuse(!(p.portal.landside < p.portal.waterside), "the portal's landside rail must be landward of its waterside one", p.portal.landside);
  refuse(!(p.lower[static_cast<std::size_t>(Joint::hoist)] > 0.0), "the rope's shortest length must be positive",
         p.lower[static_cast<std::size_t>(Joint::hoist)]);
}

void check(const WindParameters& p) {
  require_not_negative({{"the wind's gust", p.gust}, {"the wind's area", p.area}});
  refuse(!(std::fabs(p.mean) <= 100.0), "the wind's mean must be within 100 m/s", p.mean);
  refuse(p.gust > 100.0, "the wind's gust must be within 100 m/s", p.gust);
  refuse(!std::isfinite(p.direction), "the wind's direction must be a number", p.direction);
}

void check(const SensorParameters& p) {
  require_positive({{"sway_range", p.sway_range}});
  require_not_negative({{"sway_noise", p.sway_noise}});
  refuse(!(p.range_rate >= 0.0 && p.range_rate <= 1000.0), "range_rate must be 0 to 1000 Hz", p.range_rate);
  refuse(!(p.range_dropout >= 0.0 && p.range_dropout <= 1.0), "range_dropout must be 0 to 1", p.range_dropout);
}

void check(const Mover& m, const std::string& name) {
  const auto bad = [&name](const char* what) { throw std::invalid_argument(fmt::format("plant: {} {}", name, what)); };
  if (!(m.radius > 0.0 && m.height > 0.0 && std::isfinite(m.radius + m.height))) bad("needs a positive radius and height");
  if (m.path.empty()) bad("needs at least one waypoint");
  for (std::size_t i = 0; i < m.path.size(); ++i) {
    if (!std::isfinite(m.path[i].time + m.path[i].x + m.path[i].y)) bad("has a waypoint that is no number");
    if (i > 0 && !(m.path[i].time > m.path[i - 1].time)) bad("needs waypoints of rising times");
  }
}

void check(const DockConfig& c) {
  refuse(c.agv_count < 0 || c.agv_count > 16, "agv_count must be 0..16", c.agv_count);
  refuse(!(c.tolerance >= 1e-12 && c.tolerance <= 1e-4), "tolerance must be 1e-12..1e-4", c.tolerance);
  refuse(c.signal_decimation < 0, "signal_decimation must be 0 (off) or a number of latches", c.signal_decimation);
  require_positive({{"scan_dx", c.layout.scan_dx}, {"slot_spacing", c.layout.slot_spacing}, {"rated_load", c.rated_load}});
  require_not_negative({{"drive_timeout", c.drive_timeout}, {"warehouse_radius", c.layout.warehouse_radius},
                        {"warehouse_take", c.layout.warehouse_take}});
  refuse(c.layout.rows.empty(), "the bay needs at least one row", 0.0);
  for (const double row : c.layout.rows) refuse(!std::isfinite(row), "a row's place must be a number", row);
  for (const double x : {c.layout.deck, c.layout.scan_x0}) refuse(!std::isfinite(x), "deck and scan_x0 must be numbers", x);
  for (const Pose& at : {c.layout.spot, c.layout.warehouse})
    for (const double x : {at.x, at.y, at.heading}) refuse(!std::isfinite(x), "spot and warehouse must be poses of numbers", x);
  check(c.crane);
  check(c.landing);
  check(c.agv);
  check(c.wind);
  check(c.layout.ship, "the ship");
  for (std::size_t i = 0; i < c.layout.no_go.size(); ++i) check(c.layout.no_go[i], fmt::format("box {}", i));
  refuse(!(c.ship.scale >= 0.0 && c.ship.scale <= 10.0), "the ship's scale of motion must be 0 to 10", c.ship.scale);
  refuse(!(c.ship.draught >= 0.0 && c.ship.draught <= 1e-4), "the ship's draught must be 0 to 1e-4 m/kg", c.ship.draught);
  check(c.sensors);
  for (std::size_t i = 0; i < c.layout.movers.size(); ++i) check(c.layout.movers[i], fmt::format("mover {}", i));
  check_containers(c);
  check_reach(c);
  check_apart(c);
  check_standing(c);
  check_lanes(c);
}

}  // namespace plant
