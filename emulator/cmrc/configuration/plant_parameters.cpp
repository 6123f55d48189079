#include "cmrc/configuration/plant_parameters.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "plant/parameters/check.hpp"
#include "plant/parameters/holding.hpp"

namespace cmrc {
namespace {

using plant::CraneKind;
using plant::DockConfig;
using plant::DriveParameters;
using plant::Joint;

constexpr double degree = std::numbers::pi / 180.0;
constexpr double huge = 1e12;
constexpr std::string_view document = "plant-and-bus.md 1.4", assumed = "assumed", notes = "control-notes.md 2";

struct JointRow {
  std::string_view name;  // name of its table
  Joint joint;
  bool turns;  // the unit is rad, else m
};
constexpr JointRow of_slewing[] = {{"travel", Joint::gantry, false},
                                   {"slew", Joint::slew, true},
                                   {"luff", Joint::luff, true},
                                   {"hoist", Joint::hoist, false},
                                   {"rotate", Joint::rotator, true}};
constexpr JointRow of_gantry[] = {{"travel", Joint::gantry, false},
                                  {"trolley", Joint::luff, false},
                                  {"hoist", Joint::hoist, false},
                                  {"rotate", Joint::rotator, true}};

#define CRANE(member) [](DockConfig& c) -> double& { return c.crane.member; }
#define AGV(member) [](DockConfig& c) -> double& { return c.agv.member; }
#define LANDING(member) [](DockConfig& c) -> double& { return c.landing.member; }

class Rows {
 public:
  std::vector<PlantParameter> all;

  void crane(CraneKind machine, std::string table) {
    const bool slewing = machine == CraneKind::slewing;
    begin(std::move(table), machine);
    if (slewing) {
      row("a0_m", "m", 0, 100, "a0: luff pivot from the slew axis", document, CRANE(a0));
      row("jib_m", "m", 1, 200, "L: length of the jib", document, CRANE(jib));
      row("pivot_height_m", "m", 1, 200, "h_p: height of the luff pivot", document, CRANE(pivot_height));
      row("travelling_mass_kg", "kg", 1, huge, "m_g: all travelling mass except jib, counterweight and load", document,
          CRANE(gantry_mass));
      row("slew_inertia_kg_m2", "kg m2", 1, huge, "J_s: the slewing part without jib, counterweight and load", document,
          CRANE(slew_inertia));
      row("jib_mass_kg", "kg", 1, huge, "m_j", document, CRANE(jib_mass));
      row("jib_centre_m", "m", 0, 200, "c_j: centre of mass along the jib", document, CRANE(jib_centre));
      row("jib_inertia_kg_m2", "kg m2", 1, huge, "I_j, about the jib's own centre", document, CRANE(jib_inertia));
      row("counterweight_kg", "kg", 0, huge, "m_cw", document, CRANE(counterweight));
      row("counterweight_radius_m", "m", 0, 100, "r_cw", document, CRANE(counterweight_radius));
    } else {
      row("boom_height_m", "m", 1, 200, "h_p: height of the boom", document, CRANE(pivot_height));
      row("travelling_mass_kg", "kg", 1, huge, "m_g: all travelling mass except trolley and load", assumed,
          CRANE(gantry_mass));
      row("trolley_mass_kg", "kg", 1, huge, "m_t", assumed, CRANE(jib_mass));
    }
    row("spreader_mass_kg", "kg", 1, huge, "mass of spreader and headblock", document, CRANE(spreader_mass));
    row("spreader_inertia_kg_m2", "kg m2", 1, huge, "inertia about the vertical; a container adds its own", document,
        CRANE(spreader_inertia));
    row("rated_load_kg", "kg", 1, huge, "greatest load below the spreader; heavier containers are refused", document,
        CRANE(rated_load));
    row("sway_damping", "", 0, 1, "sway damping by rope and air, as a share of critical damping", document,
        CRANE(sway_damping));
    row("portal_along_m", "m", 0.1, 100, "distance of the legs before and behind the crane's middle", assumed,
        CRANE(portal.along));
    row("portal_landside_m", "m", -100, 100, "y of the rail on the land's side", assumed, CRANE(portal.landside));
    row("portal_waterside_m", "m", -100, 100, "y of the other rail", assumed, CRANE(portal.waterside));
    row("portal_leg_m", "m", 0, 10, "side of a leg; 0: none", assumed, CRANE(portal.leg));
    row("portal_height_m", "m", 0.1, 200, "height of a leg", assumed, CRANE(portal.height));
    const std::string own = table_;
    for (const JointRow& joint :
         slewing ? std::span<const JointRow>(of_slewing) : std::span<const JointRow>(of_gantry)) {
      begin(fmt::format("{}.{}", own, joint.name), machine);
      drive(joint);
    }
  }

  void vehicle() {
    begin("agv", std::nullopt);
    row("mass_kg", "kg", 100, huge, "empty", document, AGV(mass));
    row("length_m", "m", 1, 50, "length of the vehicle", document, AGV(length));
    row("width_m", "m", 0.5, 20, "width of the vehicle", document, AGV(width));
    row("front_axle_m", "m", 0.1, 25, "l_f: distance of the front axle before the centre", document, AGV(front));
    row("rear_axle_m", "m", 0.1, 25, "l_r: behind it", document, AGV(rear));
    row("yaw_inertia_kg_m2", "kg m2", 1, huge, "I_z, empty", assumed, AGV(yaw_inertia));
    row("deck_height_m", "m", 0.1, 10, "height at which a container stands", assumed, AGV(deck_height));
    row("cornering_n_rad", "N/rad", 1, huge, "C: cornering stiffness of an axle", document, AGV(cornering));
    row("adhesion", "", 0.01, 2, "mu of the tyres", document, AGV(adhesion));
    row("rolling", "", 0, 1, "C_rr: rolling resistance", assumed, AGV(rolling));
    row("drag_n_s2_m2", "N s2/m2", 0, 1e6, "C_d", assumed, AGV(drag));
    row("steer_limit_deg", "deg", 1, 85, "steering limit of either axle", document, AGV(steer_limit), degree);
    row("steer_rate_rad_s", "rad/s", 1e-3, 100, "steering rate of either axle", document, AGV(steer_rate));
    row("steer_lag_s", "s", 1e-3, 10, "lag of the steering of either axle", document, AGV(steer_lag));
    row("drive_lag_s", "s", 1e-3, 10, "lag of the driving force", document, AGV(drive_lag));
    row("acceleration_m_s2", "m/s2", 1e-3, 20, "acceleration of the drive's speed ramp", document, AGV(acceleration));
    row("braking_m_s2", "m/s2", 1e-3, 20, "braking of the drive's speed ramp", document, AGV(braking));
    row("emergency_m_s2", "m/s2", 1e-3, 20, "greatest braking by the brakes", document, AGV(emergency));
    row("blend_speed_m_s", "m/s", 1e-3, 5, "below this speed the model becomes a kinematic bicycle",
        "plant-and-bus.md 1.5", AGV(blend_speed));
    row("track_m", "m", 0.1, 20, "distance of the two wheels (differential drive)", assumed, AGV(track));
    row("wheel_slip_n_s_m", "N s/m", 1, huge, "force per slip speed of a wheel (differential drive)", assumed,
        AGV(wheel_slip));
    row("protective_margin_m", "m", 0, 50, "distance to an object at which the protective field stops the vehicle",
        assumed, AGV(protective_margin));
    row("speed_gain_1_s", "1/s", 0, 1e3, "gain of the drive's speed loop", assumed, AGV(speed_gain));
    row("speed_integral_1_s", "1/s", 0, 1e3, "integral gain of the drive's speed loop", assumed, AGV(speed_integral));
  }

  void landing() {
    begin("landing", std::nullopt);
    row("fall_stiffness_n", "N", 1, 1e15, "stiffness of one of the four falls times its length", "plant-and-bus.md 1.3",
        LANDING(fall_stiffness));
    row("fall_damping_n_s_m", "N s/m", 0, huge, "damping of each fall", assumed, LANDING(fall_damping));
    row("fall_spread_x_m", "m", 0, 20, "half distance of the falls, radial", assumed, LANDING(fall_spread_x));
    row("fall_spread_y_m", "m", 0, 20, "half distance of the falls, tangential", assumed, LANDING(fall_spread_y));
    row("yaw_stiffness_n_m_rad", "N m/rad", 0, 1e15, "yaw stiffness between rotator and load", assumed,
        LANDING(yaw_stiffness));
    row("yaw_damping_n_m_s_rad", "N m s/rad", 0, 1e15, "yaw damping between rotator and load", assumed,
        LANDING(yaw_damping));
    row("corner_stiffness_n_m", "N/m", 1, 1e15, "stiffness of a corner in contact", "plant-and-bus.md 1.7",
        LANDING(corner_stiffness));
    row("corner_damping_n_s_m", "N s/m", 0, huge, "damping of a corner in contact", "plant-and-bus.md 1.7",
        LANDING(corner_damping));
    row("friction", "", 0, 10, "in contact", "plant-and-bus.md 1.7", LANDING(friction));
    row("near_m", "m", 1e-3, 10, "clearance at which the load becomes a body on four falls", "plant-and-bus.md 1.6",
        LANDING(near));
    row("away_m", "m", 1e-3, 10, "clearance at which the load is a pendulum again", assumed, LANDING(away));
    row("guide_height_m", "m", 1e-3, 10, "height above the surface at which the guides begin", assumed,
        LANDING(guide_height));
    row("guide_stiffness_n_m", "N/m", 0, 1e15, "stiffness of a corner's guide", assumed, LANDING(guide_stiffness));
    row("guide_damping_n_s_m", "N s/m", 0, huge, "damping of a corner's guide", assumed, LANDING(guide_damping));
    row("seat_error_m", "m", 1e-4, 1, "lateral error up to which a corner seats", "plant-and-bus.md 1.5",
        LANDING(seat_error));
    row("seat_gap_m", "m", 1e-5, 0.1, "a corner switch closes below this gap", assumed, LANDING(seat_gap));
    row("touch_speed_m_s", "m/s", 0, 10, "vertical speed above which a touch is hard", "plant-and-bus.md 1.5",
        LANDING(touch_speed));
    row("touch_sway_m_s", "m/s", 0, 10, "horizontal speed above which a touch is hard", "plant-and-bus.md 1.5",
        LANDING(touch_sway));
    row("yaw_error_deg", "deg", 0, 90, "greatest rotation of the load in a strict touch", "plant-and-bus.md 1.5",
        LANDING(yaw_error), degree);
    row("lock_time_s", "s", 0, 60, "time in which the twist locks turn", "plant-and-bus.md 1.5", LANDING(lock_time));
  }

 private:
  void begin(std::string table, std::optional<CraneKind> machine) {
    table_ = std::move(table);
    machine_ = machine;
  }
  void row(std::string_view key, std::string_view unit, double minimum, double maximum, std::string_view meaning,
           std::string_view source, std::function<double&(DockConfig&)> at, double scale = 1.0) {
    all.push_back({fmt::format("{}.{}", table_, key), std::string(unit), scale, minimum, maximum, std::string(meaning),
                   std::string(source), machine_, std::move(at)});
  }
  void drive(const JointRow& joint) {
    const auto j = static_cast<std::size_t>(joint.joint);
    const auto at = [j](double DriveParameters::* member) {
      return [j, member](DockConfig& c) -> double& { return c.crane.drives[j].*member; };
    };
    const std::string_view unit = joint.turns ? "deg" : "m";
    const double scale = joint.turns ? degree : 1.0;
    row(
        fmt::format("lower_{}", unit), unit, -1e4, 1e4, "lower end stop", assumed,
        [j](DockConfig& c) -> double& { return c.crane.lower[j]; }, scale);
    row(
        fmt::format("upper_{}", unit), unit, -1e4, 1e4, "upper end stop", assumed,
        [j](DockConfig& c) -> double& { return c.crane.upper[j]; }, scale);
    row("rated_torque_n_m", "N m", 1e-3, huge,
        "torque of the motors that share the joint; times the rated speed it is their power", document,
        at(&DriveParameters::rated_torque));
    row("rated_speed_rad_s", "rad/s", 1e-3, 1e5, "speed of the motors", document, at(&DriveParameters::rated_speed));
    row(joint.turns ? "gear" : "gear_rad_m", joint.turns ? "" : "rad/m", 1e-3, 1e7,
        "n: motor rotation per joint rotation", document, at(&DriveParameters::gear));
    row("rotor_inertia_kg_m2", "kg m2", 0, huge, "inertia of the motors' rotors", document,
        at(&DriveParameters::rotor_inertia));
    row("efficiency", "", 0.01, 1, "eta of the gear", document, at(&DriveParameters::efficiency));
    row("torque_lag_s", "s", 1e-5, 10, "lag of the current loop, first order", document,
        at(&DriveParameters::torque_lag));
    row("coulomb", "", 0, 1, "F_c as a share of the rated joint force", document, at(&DriveParameters::coulomb));
    row("stribeck", "", 0, 10, "F_s / F_c", document, at(&DriveParameters::stribeck));
    row("viscous", "", 0, 1, "b: share of the rated joint force at rated speed", document,
        at(&DriveParameters::viscous));
    row("smooth_speed", "", 1e-6, 1, "v_0 as a share of the rated speed", document, at(&DriveParameters::smooth_speed));
    row("stribeck_speed", "", 1e-6, 1, "v_s as a share of the rated speed", assumed,
        at(&DriveParameters::stribeck_speed));
    row("brake", "", 0, 100, "holding brake as a share of the rated joint force", assumed, at(&DriveParameters::brake));
    row("peak", "", 1, 10, "u_max, the torque at code 2047, as a share of the rated torque", "ruling 9",
        at(&DriveParameters::peak));
    row("overspeed", "", 1, 10, "speed that trips the drive, as a share of the rated speed", notes,
        at(&DriveParameters::overspeed));
    row("overspeed_time_s", "s", 1e-4, 1e4, "time for which the overspeed has to last", notes,
        at(&DriveParameters::overspeed_time));
    row("saturation_time_s", "s", 1e-4, 1e6, "code 2047 without a break for this time trips the drive", notes,
        at(&DriveParameters::saturation_time));
    row("saturation_swings", "", 1, 1e6,
        "this number of swings of the code from one end to the other, each within saturation_time_s of the one before, "
        "trips the drive",
        "docs/plant.md", at(&DriveParameters::saturation_swings));
    row("thermal_time_s", "s", 1e-3, 1e7, "time constant of the drive's thermal model", notes,
        at(&DriveParameters::thermal_time));
    row("thermal_trip", "", 1, 10,
        "heat that trips the drive; 1 is the steady heat at rated torque, and the level of the warning", notes,
        at(&DriveParameters::thermal_trip));
  }

  std::string table_;
  std::optional<CraneKind> machine_;
};

#undef CRANE
#undef AGV
#undef LANDING

DockConfig dock_with(CraneKind machine) {
  return machine == CraneKind::gantry ? plant::gantry_dock() : plant::default_dock();
}

/// The nearest number with twelve digits: a default converted from other units gets its intended decimal form.
double written(double value) { return std::strtod(fmt::format("{:.12g}", value).c_str(), nullptr); }

}  // namespace

std::span<const PlantParameter> plant_parameters() {
  static const std::vector<PlantParameter> all = [] {
    Rows rows;
    rows.crane(CraneKind::slewing, "slewing");
    rows.crane(CraneKind::gantry, "gantry");
    rows.vehicle();
    rows.landing();
    return std::move(rows.all);
  }();
  return all;
}

const std::vector<double>& plant_defaults() {
  static const std::vector<double> all = [] {
    DockConfig slewing = dock_with(CraneKind::slewing), gantry = dock_with(CraneKind::gantry);
    std::vector<double> values;
    for (const PlantParameter& row : plant_parameters())
      values.push_back(written(row.at(row.machine == CraneKind::gantry ? gantry : slewing) / row.scale));
    return values;
  }();
  return all;
}

void place_plant_parameters(DockConfig& dock, const std::vector<double>& values) {
  const auto rows = plant_parameters();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (values[i] == plant_defaults()[i] || (rows[i].machine && *rows[i].machine != dock.crane.machine)) continue;
    rows[i].at(dock) = values[i] * rows[i].scale;
  }
}

std::optional<PlantFault> plant_fault(CraneKind machine, const std::vector<double>& values, double container_mass) {
  DockConfig dock = dock_with(machine);
  place_plant_parameters(dock, values);
  try {
    plant::check(dock.crane);
    plant::check(dock.agv);
    plant::check(dock.landing);
  } catch (const std::invalid_argument& error) {
    return PlantFault{error.what(), "parameters that can be built are expected"};
  }
  if (std::string why = plant::cannot_hold(dock.crane, dock.crane.rated_load); !why.empty())
    return PlantFault{std::move(why), "a smaller rated_load_kg or stronger drives are expected"};
  if (std::string why = plant::cannot_hold(dock.crane, container_mass); !why.empty())
    return PlantFault{std::move(why), "a lighter container or stronger drives are expected", true};
  if (container_mass > dock.crane.rated_load)
    return PlantFault{
        fmt::format(
            "{:g} kg is more than the crane's rated load of {:g} kg, though its hoist would hold them with {:.0f} N m",
            container_mass, dock.crane.rated_load, plant::hoist_holding_torque(dock.crane, container_mass)),
        "a lighter container or a larger rated_load_kg is expected", true};
  return std::nullopt;
}

}  // namespace cmrc
