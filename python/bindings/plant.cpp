#include <pybind11/stl.h>

#include "plant/crane.hpp"
#include "plant/dock.hpp"
#include "plant/motion.hpp"
#include "python/bindings/bindings.hpp"

using namespace plant;

namespace {

void bind_crane_parameters(py::module_& m) {
  py::class_<DriveParameters>(m, "DriveParameters", "One joint's drive; torques on the motor side, N m.")
      .def_readwrite("rated_torque", &DriveParameters::rated_torque)
      .def_readwrite("rated_speed", &DriveParameters::rated_speed)
      .def_readwrite("gear", &DriveParameters::gear)
      .def_readwrite("rotor_inertia", &DriveParameters::rotor_inertia)
      .def_readwrite("efficiency", &DriveParameters::efficiency)
      .def_readwrite("torque_lag", &DriveParameters::torque_lag)
      .def_readwrite("coulomb", &DriveParameters::coulomb)
      .def_readwrite("stribeck", &DriveParameters::stribeck)
      .def_readwrite("viscous", &DriveParameters::viscous)
      .def_readwrite("smooth_speed", &DriveParameters::smooth_speed)
      .def_readwrite("stribeck_speed", &DriveParameters::stribeck_speed)
      .def_readwrite("brake", &DriveParameters::brake)
      .def_property_readonly("maximum_torque", &DriveParameters::maximum_torque)
      .def_property_readonly("rated_force", &DriveParameters::rated_force)
      .def_property_readonly("rated_joint_speed", &DriveParameters::rated_joint_speed);
  py::class_<CraneParameters>(m, "CraneParameters")
      .def(py::init<>())
      .def_readwrite("a0", &CraneParameters::a0)
      .def_readwrite("jib", &CraneParameters::jib)
      .def_readwrite("pivot_height", &CraneParameters::pivot_height)
      .def_readwrite("gantry_mass", &CraneParameters::gantry_mass)
      .def_readwrite("slew_inertia", &CraneParameters::slew_inertia)
      .def_readwrite("jib_mass", &CraneParameters::jib_mass)
      .def_readwrite("jib_centre", &CraneParameters::jib_centre)
      .def_readwrite("jib_inertia", &CraneParameters::jib_inertia)
      .def_readwrite("counterweight", &CraneParameters::counterweight)
      .def_readwrite("counterweight_radius", &CraneParameters::counterweight_radius)
      .def_readwrite("spreader_mass", &CraneParameters::spreader_mass)
      .def_readwrite("spreader_inertia", &CraneParameters::spreader_inertia)
      .def_readwrite("sway_damping", &CraneParameters::sway_damping)
      .def_readwrite("lower", &CraneParameters::lower)
      .def_readwrite("upper", &CraneParameters::upper)
      .def_property(
          "drives", [](CraneParameters& p) { return std::vector<DriveParameters>(p.drives.begin(), p.drives.end()); },
          [](CraneParameters& p, const std::array<DriveParameters, joint_count>& drives) { p.drives = drives; });
  py::class_<CranePose>(m, "CranePose")
      .def(py::init<double, double, double, double, double>(), py::arg("s"), py::arg("x"), py::arg("y"), py::arg("z"),
           py::arg("yaw"))
      .def_readwrite("s", &CranePose::s)
      .def_readwrite("x", &CranePose::x)
      .def_readwrite("y", &CranePose::y)
      .def_readwrite("z", &CranePose::z)
      .def_readwrite("yaw", &CranePose::yaw);
}

void bind_motion(py::module_& m) {
  py::class_<Crane>(m, "Crane", "The crane's equations in closed form; q = (s, psi, phi, l, alpha, beta, kappa), SI units.")
      .def(py::init<const CraneParameters&>())
      .def("mass_matrix",
           [](const Crane& c, const CraneVector& q, double mass, double inertia) { return c.mass_matrix(q, {mass, inertia}); },
           py::arg("q"), py::arg("mass"), py::arg("inertia"))
      .def("bias",
           [](const Crane& c, const CraneVector& q, const CraneVector& qd, double mass, double inertia) {
             return c.bias(q, qd, {mass, inertia});
           },
           py::arg("q"), py::arg("qd"), py::arg("mass"), py::arg("inertia"))
      .def("gravity",
           [](const Crane& c, const CraneVector& q, double mass) { return c.gravity_force(q, {mass, 0.0}); }, py::arg("q"),
           py::arg("mass"))
      .def("acceleration",
           [](const Crane& c, const CraneVector& q, const CraneVector& qd, const CraneVector& force, double mass,
              double inertia, unsigned locked) { return c.acceleration(q, qd, force, {mass, inertia}, locked); },
           py::arg("q"), py::arg("qd"), py::arg("force"), py::arg("mass"), py::arg("inertia"), py::arg("locked") = 0U,
           "qdd under generalised forces; locked: bit k holds coordinate k at rest")
      .def("kinetic_energy",
           [](const Crane& c, const CraneVector& q, const CraneVector& qd, double mass, double inertia) {
             return c.kinetic_energy(q, qd, {mass, inertia});
           },
           py::arg("q"), py::arg("qd"), py::arg("mass"), py::arg("inertia"))
      .def("potential_energy",
           [](const Crane& c, const CraneVector& q, double mass) { return c.potential_energy(q, {mass, 0.0}); }, py::arg("q"),
           py::arg("mass"))
      .def("friction", &Crane::friction, py::arg("joint"), py::arg("speed"))
      .def("tip", &Crane::tip, py::arg("q"))
      .def("payload_position", &Crane::payload_position, py::arg("q"))
      .def("tip_velocity", &Crane::tip_velocity, py::arg("q"), py::arg("qd"))
      .def("payload_velocity", &Crane::payload_velocity, py::arg("q"), py::arg("qd"));
  m.def("inverse_kinematics", &inverse_kinematics, py::arg("crane"), py::arg("pose"));

  py::class_<CraneState>(m, "CraneState")
      .def(py::init<>())
      .def_readwrite("q", &CraneState::q)
      .def_readwrite("qd", &CraneState::qd)
      .def_readwrite("torque", &CraneState::torque)
      .def_readwrite("step", &CraneState::step);
  py::class_<CraneInputs>(m, "CraneInputs")
      .def(py::init<>())
      .def_readwrite("command", &CraneInputs::command)
      .def_readwrite("braked", &CraneInputs::braked)
      .def_readwrite("locked", &CraneInputs::locked)
      .def_readwrite("external", &CraneInputs::external)
      .def_property(
          "payload", [](const CraneInputs& i) { return std::pair{i.payload.mass, i.payload.inertia}; },
          [](CraneInputs& i, std::pair<double, double> p) { i.payload = {p.first, p.second}; });
  py::class_<CraneMotion>(m, "CraneMotion", "The crane with drives and friction, integrated by SUNDIALS.")
      .def(py::init<const CraneParameters&, double, int>(), py::arg("crane"), py::arg("tolerance") = 1e-8, py::arg("order") = 4)
      .def("advance", &CraneMotion::advance, py::arg("state"), py::arg("inputs"), py::arg("seconds"))
      .def("advance_fixed", &CraneMotion::advance_fixed, py::arg("state"), py::arg("inputs"), py::arg("seconds"), py::arg("step"))
      .def("advance_reference", &CraneMotion::advance_reference, py::arg("state"), py::arg("inputs"), py::arg("seconds"),
           py::arg("stiff") = false)
      .def("acceleration", &CraneMotion::acceleration, py::arg("state"), py::arg("inputs"))
      .def("holding_force", &CraneMotion::holding_force, py::arg("state"), py::arg("inputs"));
}

}  // namespace

void bind_plant(py::module_& core) {
  auto m = core.def_submodule("plant", "Crane, AGVs, containers, drives and sensors. Times are integer picoseconds.");
  m.attr("gravity") = gravity;
  bind_crane_parameters(m);
  bind_motion(m);
}
