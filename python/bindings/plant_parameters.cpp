// Crane, vehicles, landing, sensors, wind and ship: their parameters (plant/parameters/config.hpp gives each value's
// unit and source).
#include <pybind11/native_enum.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "plant/numerics/noise.hpp"
#include "plant/parameters/check.hpp"
#include "plant/parameters/config.hpp"
#include "plant/scene/wind.hpp"
#include "python/bindings/plant.hpp"

using namespace plant;

namespace {

void bind_drive(py::module_& m) {
  using P = DriveParameters;
  py::class_<P>(m, "DriveParameters", "One joint's drive; torques on the motor side, N m.")
      .def(py::init<>()) FIELD(rated_torque) FIELD(rated_speed) FIELD(gear) FIELD(rotor_inertia) FIELD(efficiency)
          FIELD(torque_lag) FIELD(coulomb) FIELD(stribeck) FIELD(viscous) FIELD(smooth_speed) FIELD(stribeck_speed)
              FIELD(brake) FIELD(peak) FIELD(overspeed) FIELD(overspeed_time) FIELD(saturation_time)
                  FIELD(saturation_swings) FIELD(thermal_time) FIELD(thermal_trip)
      .def_property_readonly("maximum_torque", &P::maximum_torque)
      .def_property_readonly("rated_force", &P::rated_force)
      .def_property_readonly("rated_joint_speed", &P::rated_joint_speed);
}

void bind_crane(py::module_& m) {
  py::native_enum<CraneKind>(m, "Machine", "enum.Enum")
      .value("slewing", CraneKind::slewing)
      .value("gantry", CraneKind::gantry)
      .finalize();
  {
    using P = Portal;
    py::class_<P>(m, "Portal",
                  "The crane's four legs, which travel with it: before and behind it, the rails' y, side and height of "
                  "a leg, m; leg 0: none.")
        .def(py::init<>()) FIELD(along) FIELD(landside) FIELD(waterside) FIELD(leg) FIELD(height);
  }
  using P = CraneParameters;
  py::class_<P>(m, "CraneParameters",
                "Geometry (m), masses (kg, kg m2), limits and drives of a crane (plant-and-bus.md 1.4, docs/plant.md).")
      .def(py::init<>()) FIELD(machine) FIELD(portal) FIELD(a0) FIELD(jib) FIELD(pivot_height) FIELD(gantry_mass)
          FIELD(slew_inertia) FIELD(jib_mass) FIELD(jib_centre) FIELD(jib_inertia) FIELD(counterweight)
              FIELD(counterweight_radius) FIELD(spreader_mass) FIELD(spreader_inertia) FIELD(rated_load)
                  FIELD(sway_damping) FIELD(gear_losses) FIELD(stiction) FIELD(lower) FIELD(upper)
      .def_property(
          "drives", [](const P& p) { return std::vector<DriveParameters>(p.drives.begin(), p.drives.end()); },
          [](P& p, const std::array<DriveParameters, joint_count>& drives) { p.drives = drives; });
  m.def("gantry_crane", &gantry_crane, "parameters of a ship-to-shore gantry");
  m.def("drive_channels", &drive_channels, py::arg("machine"), "the joint behind each drive channel of the bus");
}

void bind_landing(py::module_& m) {
  using P = LandingParameters;
  py::class_<P>(
      m, "LandingParameters",
      "The payload near contact (level L2) and the landing: N, N/m, N s/m, m, rad, s (plant-and-bus.md 1.3, 1.5).")
      .def(py::init<>()) FIELD(fall_stiffness) FIELD(fall_damping) FIELD(fall_spread_x) FIELD(fall_spread_y)
          FIELD(yaw_stiffness) FIELD(yaw_damping) FIELD(corner_stiffness) FIELD(corner_damping) FIELD(friction)
              FIELD(near) FIELD(away) FIELD(guides) FIELD(guide_window) FIELD(guide_height) FIELD(guide_stiffness)
                  FIELD(guide_damping) FIELD(seat_error) FIELD(seat_gap) FIELD(touch_speed) FIELD(touch_sway)
                      FIELD(strict) FIELD(yaw_error) FIELD(lock_time);
}

void bind_agv(py::module_& m) {
  py::native_enum<AgvDrive>(m, "AgvDrive", "enum.Enum")
      .value("steered", AgvDrive::steered)
      .value("differential", AgvDrive::differential)
      .finalize();
  using P = AgvParameters;
  py::class_<P>(m, "AgvParameters",
                "A container transporter: kg, m, kg m2, N/rad, rad, s, m/s2 (plant-and-bus.md 1.4, 1.5).")
      .def(py::init<>()) FIELD(drive) FIELD(mass) FIELD(length) FIELD(width) FIELD(front) FIELD(rear) FIELD(yaw_inertia)
          FIELD(deck_height) FIELD(cornering) FIELD(adhesion) FIELD(rolling) FIELD(drag) FIELD(steer_limit)
              FIELD(steer_rate) FIELD(steer_lag) FIELD(drive_lag) FIELD(acceleration) FIELD(braking) FIELD(emergency)
                  FIELD(blend_speed) FIELD(track) FIELD(wheel_slip) FIELD(protective_field) FIELD(protective_margin)
                      FIELD(speed_gain) FIELD(speed_integral);
}

void bind_sensors(py::module_& m) {
  using P = SensorParameters;
  py::class_<P>(
      m, "SensorParameters",
      "Sway sensor (rad) and range sensors (Hz, probability); seed of their noise (plant-and-bus.md 1.4, 1.5).")
      .def(py::init<>()) FIELD(sway_range) FIELD(sway_noise) FIELD(second_sway) FIELD(range_rate) FIELD(range_dropout)
          FIELD(seed);
}

void bind_weather(py::module_& m) {
  {
    using P = WindParameters;
    py::class_<P>(m, "WindParameters", "Mean and gusts in m/s, direction (towards) in rad, drag area in m2, seed.")
        .def(py::init<>()) FIELD(mean) FIELD(gust) FIELD(direction) FIELD(side_area) FIELD(end_area)
            FIELD(spreader_area) FIELD(seed);
  }
  m.def(
      "wind_speed",
      [](const WindParameters& p, const py::object& seconds) -> py::object {
        check(p);
        return py::vectorize([wind = Wind(p)](double t) mutable { return wind.speed(t); })(
            py::array_t<double>(seconds));
      },
      py::arg("wind"), py::arg("seconds"), "m/s, the mean and the seeded gusts, at an instant or an array of them (s)");
  py::native_enum<Stream>(m, "Stream", "enum.Enum")
      .value("sway_radial", Stream::sway_radial)
      .value("sway_tangential", Stream::sway_tangential)
      .value("second_sway_radial", Stream::second_sway_radial)
      .value("second_sway_tangential", Stream::second_sway_tangential)
      .value("range_dropout", Stream::range_dropout)
      .value("wind_frequency", Stream::wind_frequency)
      .value("wind_phase", Stream::wind_phase)
      .value("ship_surge", Stream::ship_surge)
      .value("ship_sway", Stream::ship_sway)
      .value("ship_heave", Stream::ship_heave)
      .value("ship_roll", Stream::ship_roll)
      .value("ship_pitch", Stream::ship_pitch)
      .finalize();
  m.def("normal", &normal, py::arg("seed"), py::arg("stream"), py::arg("sample"),
        "standard normal deviate of a stream of noise");
  m.def("uniform", &uniform, py::arg("seed"), py::arg("stream"), py::arg("sample"),
        "number between 0 and 1 of a stream of noise");
  using P = ShipMotion;
  py::class_<P>(
      m, "ShipMotion",
      "A moored ship: scale of its motion, m that it rises per kg that leaves it, seed (plant-and-bus.md 1.5).")
      .def(py::init<>()) FIELD(scale) FIELD(draught) FIELD(seed);
}

}  // namespace

void bind_plant_parameters(py::module_& m) {
  m.attr("gravity") = gravity;
  bind_drive(m);
  bind_crane(m);
  bind_landing(m);
  bind_agv(m);
  bind_sensors(m);
  bind_weather(m);
}
