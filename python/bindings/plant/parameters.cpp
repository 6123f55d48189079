// Crane, vehicles, landing, sensors, wind and ship: their parameters (plant/parameters/config.hpp gives each value's
// unit and source).
#include <pybind11/native_enum.h>
#include <pybind11/stl.h>

#include <span>
#include <string>

#include "plant/parameters/config.hpp"
#include "plant/parameters/parameter_rows.hpp"
#include "python/bindings/plant/plant.hpp"

using namespace plant;

namespace {

/// A member for each row; several rows may be of one member, for different cranes or joints.
template <class P>
py::class_<P>& add_members(py::class_<P>& owner, std::span<const ParameterRow<P>> rows) {
  for (const auto& row : rows) {
    const std::string name(row.member), meaning(row.meaning);
    if (!py::hasattr(owner, name.c_str())) owner.def_readwrite(name.c_str(), row.at, meaning.c_str());
  }
  return owner;
}

void bind_drive(py::module_& m) {
  using P = DriveParameters;
  py::class_<P> drive(m, "DriveParameters", "One joint's drive; torques on the motor side, N m.");
  add_members(drive, drive_rows())
      .def(py::init<>())
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
    py::class_<P> portal(
        m, "Portal",
        "The crane's four legs, which travel with it: before and behind it, the rails' y, side and height of "
        "a leg, m; leg 0: none.");
    add_members(portal, portal_rows()).def(py::init<>());
  }
  using P = CraneParameters;
  py::class_<P> crane(
      m, "CraneParameters",
      "Geometry (m), masses (kg, kg m2), limits and drives of a crane (plant-and-bus.md 1.4, docs/plant.md).");
  add_members(crane, crane_rows())
      .def(py::init<>()) FIELD(machine) FIELD(portal) FIELD(gear_losses) FIELD(stiction) FIELD(lower) FIELD(upper)
          FIELD(drives);
  m.def("gantry_crane", &gantry_crane, "parameters of a ship-to-shore gantry");
}

void bind_landing(py::module_& m) {
  using P = LandingParameters;
  py::class_<P> landing(
      m, "LandingParameters",
      "The payload near contact (level L2) and the landing: N, N/m, N s/m, m, rad, s (plant-and-bus.md 1.3, 1.5).");
  add_members(landing, landing_rows()).def(py::init<>()) FIELD(guides) FIELD(guide_window) FIELD(strict);
}

void bind_agv(py::module_& m) {
  py::native_enum<AgvDrive>(m, "AgvDrive", "enum.Enum")
      .value("steered", AgvDrive::steered)
      .value("differential", AgvDrive::differential)
      .finalize();
  using P = AgvParameters;
  py::class_<P> agv(m, "AgvParameters",
                    "A container transporter: kg, m, kg m2, N/rad, rad, s, m/s2 (plant-and-bus.md 1.4, 1.5).");
  add_members(agv, agv_rows()).def(py::init<>()) FIELD(drive) FIELD(protective_field);
}

}  // namespace

void bind_plant_parameters(py::module_& m) {
  m.attr("gravity") = gravity;
  bind_drive(m);
  bind_crane(m);
  bind_landing(m);
  bind_agv(m);
}
