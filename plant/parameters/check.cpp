#include "plant/parameters/check.hpp"

#include <fmt/format.h>

#include <cmath>
#include <initializer_list>
#include <stdexcept>
#include <string>

#include "plant/scene/wind.hpp"

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

void check(const Box& b, const std::string& name) {
  const bool ordered = b.x_min < b.x_max && b.y_min < b.y_max && b.z_min < b.z_max;
  if (!ordered) throw std::invalid_argument(fmt::format("plant: {} needs min < max along x, y and z", name));
}

}  // namespace

void refuse(bool bad, const char* what, double value) {
  if (bad) throw std::invalid_argument(fmt::format("plant: {} (got {})", what, value));
}

void check(const AgvParameters& p) {
  require_positive({{"an AGV's mass", p.mass},
                    {"an AGV's length", p.length},
                    {"an AGV's width", p.width},
                    {"an AGV's front", p.front},
                    {"an AGV's rear", p.rear},
                    {"an AGV's yaw_inertia", p.yaw_inertia},
                    {"an AGV's deck_height", p.deck_height},
                    {"an AGV's cornering", p.cornering},
                    {"an AGV's adhesion", p.adhesion},
                    {"an AGV's steer_rate", p.steer_rate},
                    {"an AGV's steer_lag", p.steer_lag},
                    {"an AGV's drive_lag", p.drive_lag},
                    {"an AGV's acceleration", p.acceleration},
                    {"an AGV's braking", p.braking},
                    {"an AGV's emergency", p.emergency},
                    {"an AGV's blend_speed", p.blend_speed},
                    {"an AGV's track", p.track},
                    {"an AGV's wheel_slip", p.wheel_slip}});
  require_not_negative({{"an AGV's rolling", p.rolling},
                        {"an AGV's drag", p.drag},
                        {"an AGV's speed_gain", p.speed_gain},
                        {"an AGV's speed_integral", p.speed_integral},
                        {"an AGV's protective_margin", p.protective_margin}});
  refuse(!(p.steer_limit > 0.0 && p.steer_limit < 1.5), "an AGV's steer_limit must be above 0 and below 1.5 rad",
         p.steer_limit);
}

void check(const LandingParameters& p) {
  require_positive({{"fall_stiffness", p.fall_stiffness},
                    {"corner_stiffness", p.corner_stiffness},
                    {"landing's near", p.near},
                    {"guide_window", p.guide_window},
                    {"guide_height", p.guide_height},
                    {"seat_error", p.seat_error},
                    {"seat_gap", p.seat_gap}});
  require_not_negative({{"fall_damping", p.fall_damping},
                        {"fall_spread_x", p.fall_spread_x},
                        {"fall_spread_y", p.fall_spread_y},
                        {"yaw_stiffness", p.yaw_stiffness},
                        {"yaw_damping", p.yaw_damping},
                        {"corner_damping", p.corner_damping},
                        {"friction", p.friction},
                        {"guide_stiffness", p.guide_stiffness},
                        {"guide_damping", p.guide_damping},
                        {"touch_speed", p.touch_speed},
                        {"touch_sway", p.touch_sway},
                        {"lock_time", p.lock_time}});
  refuse(!(p.away > p.near), "landing's away must be more than its near", p.away);
}

void check(const CraneParameters& p) {
  require_positive({{"jib", p.jib},
                    {"pivot_height", p.pivot_height},
                    {"gantry_mass", p.gantry_mass},
                    {"slew_inertia", p.slew_inertia},
                    {"jib_mass", p.jib_mass},
                    {"jib_inertia", p.jib_inertia},
                    {"spreader_mass", p.spreader_mass},
                    {"spreader_inertia", p.spreader_inertia}});
  require_not_negative({{"a0", p.a0},
                        {"jib_centre", p.jib_centre},
                        {"counterweight", p.counterweight},
                        {"counterweight_radius", p.counterweight_radius},
                        {"sway_damping", p.sway_damping},
                        {"rated_load", p.rated_load}});
  for (const DriveParameters& d : p.drives) {
    require_positive({{"a drive's rated_torque", d.rated_torque},
                      {"a drive's rated_speed", d.rated_speed},
                      {"a drive's gear", d.gear},
                      {"a drive's torque_lag", d.torque_lag},
                      {"a drive's smooth_speed", d.smooth_speed},
                      {"a drive's stribeck_speed", d.stribeck_speed},
                      {"a drive's overspeed_time", d.overspeed_time},
                      {"a drive's saturation_time", d.saturation_time},
                      {"a drive's saturation_swings", d.saturation_swings},
                      {"a drive's thermal_time", d.thermal_time}});
    require_not_negative({{"a drive's rotor_inertia", d.rotor_inertia},
                          {"a drive's coulomb", d.coulomb},
                          {"a drive's stribeck", d.stribeck},
                          {"a drive's viscous", d.viscous},
                          {"a drive's brake", d.brake}});
    refuse(!(d.efficiency > 0.0 && d.efficiency <= 1.0), "a drive's efficiency must be above 0 and at most 1",
           d.efficiency);
    refuse(!(d.peak >= 1.0 && d.peak <= 10.0), "a drive's peak must be 1 to 10 times its rated torque", d.peak);
    refuse(!(d.overspeed > 1.0 && d.overspeed <= 10.0),
           "a drive's overspeed must be above 1, at most 10 times its rated speed", d.overspeed);
    refuse(!(d.thermal_trip > 1.0 && d.thermal_trip <= 10.0),
           "a drive's thermal_trip must be above 1, at most 10: the warning is at 1", d.thermal_trip);
  }
  for (std::size_t j = 0; j < joint_count; ++j)
    refuse(!(p.lower[j] < p.upper[j]), "a joint's lower limit must be below its upper one", p.lower[j]);
  require_not_negative({{"the portal's leg", p.portal.leg}});
  require_positive({{"the portal's along", p.portal.along}, {"the portal's height", p.portal.height}});
  refuse(!(p.portal.landside < p.portal.waterside), "the portal's landside rail must be landward of its waterside one",
         p.portal.landside);
  refuse(!(p.lower[static_cast<std::size_t>(Joint::hoist)] > 0.0), "the rope's shortest length must be positive",
         p.lower[static_cast<std::size_t>(Joint::hoist)]);
}

void check(const WindParameters& p) {
  require_not_negative({{"the wind's gust", p.gust},
                        {"the wind's side_area", p.side_area},
                        {"the wind's end_area", p.end_area},
                        {"the wind's spreader_area", p.spreader_area}});
  refuse(!(std::fabs(p.mean) <= 100.0), "the wind's mean must be within 100 m/s", p.mean);
  refuse(p.gust > 100.0, "the wind's gust must be within 100 m/s", p.gust);
  if (p.gust > 0.0 && std::fabs(p.mean) < least_gusty_mean)
    throw std::invalid_argument(fmt::format(
        "plant: the wind's gusts (gust = {} m/s) are carried by its mean, which must be {} m/s or more (got {})",
        p.gust, least_gusty_mean, p.mean));
  refuse(!std::isfinite(p.direction), "the wind's direction must be a number", p.direction);
}

void check(const SensorParameters& p) {
  require_positive({{"sway_range", p.sway_range}});
  require_not_negative({{"sway_noise", p.sway_noise}});
  refuse(p.range_rate != 0.0 && !(p.range_rate >= 0.001 && p.range_rate <= 1000.0),
         "range_rate must be 0 (a scan at each step of the AGVs), or 0.001 to 1000 Hz", p.range_rate);
  refuse(!(p.range_dropout >= 0.0 && p.range_dropout <= 1.0), "range_dropout must be 0 to 1", p.range_dropout);
}

void check(const Mover& m, const std::string& name) {
  const auto bad = [&name](const char* what) { throw std::invalid_argument(fmt::format("plant: {} {}", name, what)); };
  if (!(m.radius > 0.0 && m.height > 0.0 && std::isfinite(m.radius + m.height)))
    bad("needs a positive radius and height");
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
  refuse(c.signal_rows_max < 2, "signal_rows_max must be at least 2 rows", c.signal_rows_max);
  require_positive({{"scan_dx", c.layout.scan_dx}, {"slot_spacing", c.layout.slot_spacing}});
  require_not_negative({{"drive_delay", static_cast<double>(c.drive_delay)},
                        {"drive_timeout", c.drive_timeout},
                        {"warehouse_radius", c.layout.warehouse_radius}});
  refuse(!(c.layout.warehouse_take >= 0.0 && c.layout.warehouse_take <= 86400.0),
         "the warehouse's take_s must be 0 to 86400 s", c.layout.warehouse_take);
  refuse(c.layout.rows.empty(), "the bay needs at least one row", 0.0);
  for (const double row : c.layout.rows) refuse(!std::isfinite(row), "a row's place must be a number", row);
  for (const double x : {c.layout.deck, c.layout.scan_x0})
    refuse(!std::isfinite(x), "deck and scan_x0 must be numbers", x);
  for (const Pose& at : {c.layout.spot, c.layout.warehouse})
    for (const double x : {at.x, at.y, at.heading})
      refuse(!std::isfinite(x), "spot and warehouse must be poses of numbers", x);
  check(c.crane);
  // Near contact the load is a body of its own, and only the rotor's inertia is left to these two joints.
  require_positive(
      {{"the hoist's rotor_inertia", c.crane.drives[static_cast<std::size_t>(Joint::hoist)].rotor_inertia},
       {"the rotator's rotor_inertia", c.crane.drives[static_cast<std::size_t>(Joint::rotator)].rotor_inertia}});
  check(c.landing);
  check(c.agv);
  check(c.wind);
  check(c.layout.ship, "the ship");
  for (std::size_t i = 0; i < c.layout.no_go.size(); ++i) check(c.layout.no_go[i], fmt::format("box {}", i));
  refuse(!(c.ship.scale >= 0.0 && c.ship.scale <= 10.0), "the ship's scale of motion must be 0 to 10", c.ship.scale);
  refuse(!(c.ship.draught >= 0.0 && c.ship.draught <= 1e-4), "the ship's draught must be 0 to 1e-4 m/kg",
         c.ship.draught);
  check(c.sensors);
  for (std::size_t i = 0; i < c.layout.movers.size(); ++i) check(c.layout.movers[i], fmt::format("mover {}", i));
  check_scene(c);
}

}  // namespace plant
