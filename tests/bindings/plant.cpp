// Parts of the plant without a dock: a crane that is integrated alone, and by ODE as rigid bodies; a box that falls on
// the ground.
#include <pybind11/stl.h>

#include <memory>

#include "plant/crane/crane_motion.hpp"
#include "plant/crane/ode_crane.hpp"
#include "plant/landing/contact.hpp"
#include "plant/numerics/math.hpp"
#include "plant/parameters/config.hpp"
#include "tests/bindings/bindings.hpp"

using namespace plant;

void bind_plant(py::module_& test) {
  py::module_ m = test.def_submodule("plant", "Parts of the plant without a dock.");
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
      .def(py::init([](const CraneParameters& crane, double tolerance, int order, Method method) {
             return std::make_unique<CraneMotion>(crane, Integrator::Settings{method, order, tolerance});
           }),
           py::arg("crane"), py::arg("tolerance") = 1e-8, py::arg("order") = 4, py::arg("method") = Method::erk)
      .def("advance", &CraneMotion::advance, py::arg("state"), py::arg("inputs"), py::arg("seconds"))
      .def("advance_fixed", &CraneMotion::advance_fixed, py::arg("state"), py::arg("inputs"), py::arg("seconds"),
           py::arg("step"))
      .def("acceleration", &CraneMotion::acceleration, py::arg("state"), py::arg("inputs"))
      .def("holding_force", &CraneMotion::holding_force, py::arg("state"), py::arg("inputs"));
  m.def("swing_in_ode", &swing_in_ode, py::arg("crane"), py::arg("mass"), py::arg("q"), py::arg("qd"), py::arg("force"),
        py::arg("step"), py::arg("steps"));
  m.def(
      "drop_box",
      [](double mass, std::array<double, 3> size, double gap, double speed, double slope, double step, int steps) {
        LandingParameters p;
        ContactEngine engine(p);
        BodyShape shape{};
        shape.mass = mass;
        shape.inertia = {mass * (size[1] * size[1] + size[2] * size[2]) / 12,
                         mass * (size[0] * size[0] + size[2] * size[2]) / 12,
                         mass * (size[0] * size[0] + size[1] * size[1]) / 12};
        const double x = 0.5 * size[0] - 0.1;
        const double y = 0.5 * size[1] - 0.1;
        shape.corners = {
            {{x, y, -0.5 * size[2]}, {x, -y, -0.5 * size[2]}, {-x, -y, -0.5 * size[2]}, {-x, y, -0.5 * size[2]}}};
        BodyState body;
        body.position = {0.0, 0.0, 0.5 * size[2] + gap};
        body.velocity = {0.0, 0.0, -speed};
        const std::array solid{make_solid(Solid::Kind::ground, -1, 0, 0, 0, 100, 100, -5.0, 0.0)};
        // A sideways pull and less weight model the slope: the floor stays level.
        const std::array force{mass * gravity * plant::sin(slope), 0.0, mass * gravity * (1.0 - plant::cos(slope))};
        std::vector<std::array<double, 4>> rows;
        for (int i = 0; i < steps; ++i) {
          const ContactResult r = engine.step(body, shape, force, {0.0, 0.0, 0.0}, solid, step);
          rows.push_back({body.position[2] - 0.5 * size[2], body.velocity[2], r.normal_force, body.position[0]});
        }
        return rows;
      },
      py::arg("mass"), py::arg("size"), py::arg("gap"), py::arg("speed"), py::arg("slope"), py::arg("step"),
      py::arg("steps"), "rows of (height of the underside, vertical speed, normal force, x)");
  m.def("drive_channels", &drive_channels, py::arg("machine"), "the joint behind each drive channel of the bus");
}
