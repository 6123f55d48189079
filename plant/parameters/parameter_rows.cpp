#include "plant/parameters/parameter_rows.hpp"

#include <array>

namespace plant {
namespace {

constexpr double rad_per_degree = std::numbers::pi / 180.0;
constexpr double huge = 1e12;
constexpr std::string_view document = "plant-and-bus.md 1.4", assumed = "assumed", notes = "control-notes.md 2";

}  // namespace

#define MEMBER(name) #name, &P::name

std::span<const ParameterRow<CraneParameters>> crane_rows() {
  using P = CraneParameters;
  static constexpr auto rows = std::to_array<ParameterRow<P>>({
      {MEMBER(a0), "a0_m", "m", 0, 100, "a0: luff pivot from the slew axis", document, Where::slewing},
      {MEMBER(jib), "jib_m", "m", 1, 200, "L: length of the jib", document, Where::slewing},
      {MEMBER(pivot_height), "pivot_height_m", "m", 1, 200, "h_p: height of the luff pivot", document, Where::slewing},
      {MEMBER(gantry_mass), "travelling_mass_kg", "kg", 1, huge,
       "m_g: all travelling mass except jib, counterweight and load", document, Where::slewing},
      {MEMBER(slew_inertia), "slew_inertia_kg_m2", "kg m2", 1, huge,
       "J_s: the slewing part without jib, counterweight and load", document, Where::slewing},
      {MEMBER(jib_mass), "jib_mass_kg", "kg", 1, huge, "m_j", document, Where::slewing},
      {MEMBER(jib_centre), "jib_centre_m", "m", 0, 200, "c_j: centre of mass along the jib", document, Where::slewing},
      {MEMBER(jib_inertia), "jib_inertia_kg_m2", "kg m2", 1, huge, "I_j, about the jib's own centre", document,
       Where::slewing},
      {MEMBER(counterweight), "counterweight_kg", "kg", 0, huge, "m_cw", document, Where::slewing},
      {MEMBER(counterweight_radius), "counterweight_radius_m", "m", 0, 100, "r_cw", document, Where::slewing},
      {MEMBER(pivot_height), "boom_height_m", "m", 1, 200, "h_p: height of the boom", document, Where::gantry},
      {MEMBER(gantry_mass), "travelling_mass_kg", "kg", 1, huge, "m_g: all travelling mass except trolley and load",
       assumed, Where::gantry},
      {MEMBER(jib_mass), "trolley_mass_kg", "kg", 1, huge, "m_t", assumed, Where::gantry},
      {MEMBER(spreader_mass), "spreader_mass_kg", "kg", 1, huge, "mass of spreader and headblock", document},
      {MEMBER(spreader_inertia), "spreader_inertia_kg_m2", "kg m2", 1, huge,
       "inertia about the vertical; a container adds its own", document},
      {MEMBER(rated_load), "rated_load_kg", "kg", 1, huge,
       "greatest load below the spreader; heavier containers are refused", document},
      {MEMBER(sway_damping), "sway_damping", "", 0, 1, "sway damping by rope and air, as a share of critical damping",
       document},
  });
  return rows;
}

std::span<const ParameterRow<Portal>> portal_rows() {
  using P = Portal;
  static constexpr auto rows = std::to_array<ParameterRow<P>>({
      {MEMBER(along), "portal_along_m", "m", 0.1, 100, "distance of the legs before and behind the crane's middle",
       assumed},
      {MEMBER(landside), "portal_landside_m", "m", -100, 100, "y of the rail on the land's side", assumed},
      {MEMBER(waterside), "portal_waterside_m", "m", -100, 100, "y of the other rail", assumed},
      {MEMBER(leg), "portal_leg_m", "m", 0, 10, "side of a leg; 0: none", assumed},
      {MEMBER(height), "portal_height_m", "m", 0.1, 200, "height of a leg", assumed},
  });
  return rows;
}

std::span<const ParameterRow<DriveParameters>> drive_rows() {
  using P = DriveParameters;
  static constexpr auto rows = std::to_array<ParameterRow<P>>({
      {MEMBER(rated_torque), "rated_torque_n_m", "N m", 1e-3, huge,
       "torque of the motors that share the joint; times the rated speed it is their power", document},
      {MEMBER(rated_speed), "rated_speed_rad_s", "rad/s", 1e-3, 1e5, "speed of the motors", document},
      {MEMBER(gear), "gear", "", 1e-3, 1e7, "n: motor rotation per joint rotation", document, Where::turning},
      {MEMBER(gear), "gear_rad_m", "rad/m", 1e-3, 1e7, "n: motor rotation per joint rotation", document,
       Where::sliding},
      {MEMBER(rotor_inertia), "rotor_inertia_kg_m2", "kg m2", 1e-3, huge, "inertia of the motors' rotors", document},
      {MEMBER(efficiency), "efficiency", "", 0.01, 1, "eta of the gear", document},
      {MEMBER(torque_lag), "torque_lag_s", "s", 1e-5, 10, "lag of the current loop, first order", document},
      {MEMBER(coulomb), "coulomb", "", 0, 1, "F_c as a share of the rated joint force", document},
      {MEMBER(stribeck), "stribeck", "", 0, 10, "F_s / F_c", document},
      {MEMBER(viscous), "viscous", "", 0, 1, "b: share of the rated joint force at rated speed", document},
      {MEMBER(smooth_speed), "smooth_speed", "", 1e-6, 1, "v_0 as a share of the rated speed", document},
      {MEMBER(stribeck_speed), "stribeck_speed", "", 1e-6, 1, "v_s as a share of the rated speed", assumed},
      {MEMBER(brake), "brake", "", 0, 100, "holding brake as a share of the rated joint force", assumed},
      {MEMBER(peak), "peak", "", 1, 10, "u_max, the torque at code 2047, as a share of the rated torque", "ruling 9"},
      {MEMBER(overspeed), "overspeed", "", 1, 10, "speed that trips the drive, as a share of the rated speed", notes},
      {MEMBER(overspeed_time), "overspeed_time_s", "s", 1e-4, 1e4, "time for which the overspeed has to last", notes},
      {MEMBER(saturation_time), "saturation_time_s", "s", 1e-4, 1e6,
       "code 2047 without a break for this time trips the drive", notes},
      {MEMBER(saturation_swings), "saturation_swings", "", 1, 1e6,
       "this number of swings of the code from one end to the other, each within saturation_time_s of the one before, "
       "trips the drive",
       "docs/plant.md"},
      {MEMBER(thermal_time), "thermal_time_s", "s", 1e-3, 1e7, "time constant of the drive's thermal model", notes},
      {MEMBER(thermal_trip), "thermal_trip", "", 1, 10,
       "heat that trips the drive; 1 is the steady heat at rated torque, and the level of the warning", notes},
  });
  return rows;
}

std::span<const ParameterRow<AgvParameters>> agv_rows() {
  using P = AgvParameters;
  static constexpr auto rows = std::to_array<ParameterRow<P>>({
      {MEMBER(mass), "mass_kg", "kg", 100, huge, "empty", document},
      {MEMBER(length), "length_m", "m", 1, 50, "length of the vehicle", document},
      {MEMBER(width), "width_m", "m", 0.5, 20, "width of the vehicle", document},
      {MEMBER(front), "front_axle_m", "m", 0.1, 25, "l_f: distance of the front axle before the centre", document},
      {MEMBER(rear), "rear_axle_m", "m", 0.1, 25,
       "l_r: behind it; the programs steer both axles alike, so with another l_f vehicles leave their lane", document},
      {MEMBER(yaw_inertia), "yaw_inertia_kg_m2", "kg m2", 1, huge, "I_z, empty", assumed},
      {MEMBER(deck_height), "deck_height_m", "m", 0.1, 10, "height at which a container stands", assumed},
      {MEMBER(cornering), "cornering_n_rad", "N/rad", 1, huge, "C: cornering stiffness of an axle", document},
      {MEMBER(adhesion), "adhesion", "", 0.01, 2, "mu of the tyres", document},
      {MEMBER(rolling), "rolling", "", 0, 1, "C_rr: rolling resistance", assumed},
      {MEMBER(drag), "drag_n_s2_m2", "N s2/m2", 0, 1e6, "C_d", assumed},
      {MEMBER(steer_limit), "steer_limit_deg", "deg", 1, 85, "steering limit of either axle", document,
       Where::everywhere, rad_per_degree},
      {MEMBER(steer_rate), "steer_rate_rad_s", "rad/s", 1e-3, 100, "steering rate of either axle", document},
      {MEMBER(steer_lag), "steer_lag_s", "s", 1e-3, 10, "lag of the steering of either axle", document},
      {MEMBER(drive_lag), "drive_lag_s", "s", 1e-3, 10, "lag of the driving force", document},
      {MEMBER(acceleration), "acceleration_m_s2", "m/s2", 1e-3, 20, "acceleration of the drive's speed ramp", document},
      {MEMBER(braking), "braking_m_s2", "m/s2", 1e-3, 20, "braking of the drive's speed ramp", document},
      {MEMBER(emergency), "emergency_m_s2", "m/s2", 1e-3, 20, "greatest braking by the brakes", document},
      {MEMBER(blend_speed), "blend_speed_m_s", "m/s", 1e-3, 5, "below this speed the model becomes a kinematic bicycle",
       "plant-and-bus.md 1.5"},
      {MEMBER(track), "track_m", "m", 0.1, 20, "distance of the two wheels (differential drive)", assumed},
      {MEMBER(wheel_slip), "wheel_slip_n_s_m", "N s/m", 1, huge, "force per slip speed of a wheel (differential drive)",
       assumed},
      {MEMBER(protective_margin), "protective_margin_m", "m", 0, 50,
       "distance to an object at which the protective field stops the vehicle", assumed},
      {MEMBER(speed_gain), "speed_gain_1_s", "1/s", 0, 1e3, "gain of the drive's speed loop", assumed},
      {MEMBER(speed_integral), "speed_integral_1_s", "1/s", 0, 1e3, "integral gain of the drive's speed loop", assumed},
  });
  return rows;
}

std::span<const ParameterRow<LandingParameters>> landing_rows() {
  using P = LandingParameters;
  static constexpr auto rows = std::to_array<ParameterRow<P>>({
      {MEMBER(fall_stiffness), "fall_stiffness_n", "N", 1, 1e15, "stiffness of one of the four falls times its length",
       "plant-and-bus.md 1.3"},
      {MEMBER(fall_damping), "fall_damping_n_s_m", "N s/m", 0, huge, "damping of each fall", assumed},
      {MEMBER(fall_spread_x), "fall_spread_x_m", "m", 0, 20, "half distance of the falls, radial", assumed},
      {MEMBER(fall_spread_y), "fall_spread_y_m", "m", 0, 20, "half distance of the falls, tangential", assumed},
      {MEMBER(yaw_stiffness), "yaw_stiffness_n_m_rad", "N m/rad", 0, 1e15, "yaw stiffness between rotator and load",
       assumed},
      {MEMBER(yaw_damping), "yaw_damping_n_m_s_rad", "N m s/rad", 0, 1e15, "yaw damping between rotator and load",
       assumed},
      {MEMBER(corner_stiffness), "corner_stiffness_n_m", "N/m", 1, 1e15, "stiffness of a corner in contact",
       "plant-and-bus.md 1.7"},
      {MEMBER(corner_damping), "corner_damping_n_s_m", "N s/m", 0, huge, "damping of a corner in contact",
       "plant-and-bus.md 1.7"},
      {MEMBER(friction), "friction", "", 0, 10, "in contact", "plant-and-bus.md 1.7"},
      {MEMBER(near), "near_m", "m", 1e-3, 10, "clearance at which the load becomes a body on four falls",
       "plant-and-bus.md 1.6"},
      {MEMBER(away), "away_m", "m", 1e-3, 10, "clearance at which the load is a pendulum again", assumed},
      {MEMBER(guide_height), "guide_height_m", "m", 1e-3, 10, "height above the surface at which the guides begin",
       assumed},
      {MEMBER(guide_stiffness), "guide_stiffness_n_m", "N/m", 0, 1e15, "stiffness of a corner's guide", assumed},
      {MEMBER(guide_damping), "guide_damping_n_s_m", "N s/m", 0, huge, "damping of a corner's guide", assumed},
      {MEMBER(seat_error), "seat_error_m", "m", 1e-4, 1, "lateral error up to which a corner seats",
       "plant-and-bus.md 1.5"},
      {MEMBER(seat_gap), "seat_gap_m", "m", 1e-5, 0.1, "a corner switch closes below this gap", assumed},
      {MEMBER(touch_speed), "touch_speed_m_s", "m/s", 0, 10, "vertical speed above which a touch is hard",
       "plant-and-bus.md 1.5"},
      {MEMBER(touch_sway), "touch_sway_m_s", "m/s", 0, 10, "horizontal speed above which a touch is hard",
       "plant-and-bus.md 1.5"},
      {MEMBER(yaw_error), "yaw_error_deg", "deg", 0, 90, "greatest rotation of the load in a strict touch",
       "plant-and-bus.md 1.5", Where::everywhere, rad_per_degree},
      {MEMBER(lock_time), "lock_time_s", "s", 0, 60, "time in which the twist locks turn", "plant-and-bus.md 1.5"},
  });
  return rows;
}

#undef MEMBER

}  // namespace plant
