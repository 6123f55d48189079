// The crane's equations in closed form, and their integration.
#include <pybind11/stl.h>

#include "plant/crane/crane_motion.hpp"
#include "python/bindings/plant/plant.hpp"

using namespace plant;

namespace {

void bind_equations(py::module_& m) {
  py::class_<Crane>(m, "Crane",
                    "The crane's equations in closed form; q = (s, psi, phi, l, alpha, beta, kappa), SI units.")
      .def(py::init<const CraneParameters&>(), py::arg("parameters"))
      .def(
          "mass_matrix",
          [](const Crane& c, const CraneVector& q, double mass, double inertia) {
            return c.mass_matrix(q, {mass, inertia});
          },
          py::arg("q"), py::arg("mass"), py::arg("inertia"))
      .def(
          "bias",
          [](const Crane& c, const CraneVector& q, const CraneVector& qd, double mass, double inertia) {
            return c.bias(q, qd, {mass, inertia});
          },
          py::arg("q"), py::arg("qd"), py::arg("mass"), py::arg("inertia"))
      .def(
          "gravity", [](const Crane& c, const CraneVector& q, double mass) { return c.gravity_force(q, {mass, 0.0}); },
          py::arg("q"), py::arg("mass"))
      .def(
          "acceleration",
          [](const Crane& c, const CraneVector& q, const CraneVector& qd, const CraneVector& force, double mass,
             double inertia,
             unsigned locked) { return Crane::acceleration(c.dynamics(q, qd, {mass, inertia}, locked), force); },
          py::arg("q"), py::arg("qd"), py::arg("force"), py::arg("mass"), py::arg("inertia"), py::arg("locked") = 0U,
          "qdd under generalised forces; locked: bit k holds coordinate k at rest")
      .def(
          "kinetic_energy",
          [](const Crane& c, const CraneVector& q, const CraneVector& qd, double mass, double inertia) {
            return c.kinetic_energy(q, qd, {mass, inertia});
          },
          py::arg("q"), py::arg("qd"), py::arg("mass"), py::arg("inertia"))
      .def(
          "potential_energy",
          [](const Crane& c, const CraneVector& q, double mass) { return c.potential_energy(q, {mass, 0.0}); },
          py::arg("q"), py::arg("mass"))
      .def("friction", &Crane::friction, py::arg("joint"), py::arg("speed"), py::arg("sliding") = 0)
      .def("tip", &Crane::tip, py::arg("q"))
      .def("payload_position", &Crane::payload_position, py::arg("q"))
      .def("tip_velocity", &Crane::tip_velocity, py::arg("q"), py::arg("qd"))
      .def("payload_velocity", &Crane::payload_velocity, py::arg("q"), py::arg("qd"));
  m.def("inverse_kinematics", &inverse_kinematics, py::arg("crane"), py::arg("pose"));
}

void bind_motion(py::module_& m) {
  {
    using P = CraneState;
    py::class_<P>(m, "CraneState").def(py::init<>()) FIELD(q) FIELD(qd) FIELD(torque) FIELD(step);
  }
  py::class_<Work>(m, "Work", "Where energy went, J.")
      .def_readonly("motors", &Work::motors)
      .def_readonly("gears", &Work::gears)
      .def_readonly("friction", &Work::friction)
      .def_readonly("damping", &Work::damping)
      .def_readonly("external", &Work::external)
      .def_readonly("impacts", &Work::impacts)
      .def_property_readonly("stored", &Work::stored);
}

}  // namespace

void bind_plant_motion(py::module_& m) {
  bind_equations(m);
  bind_motion(m);
}
