// A crane and an AGV by themselves, without a dock.
#include <pybind11/stl.h>

#include "plant/crane/crane_alone.hpp"
#include "plant/vehicles/agv_alone.hpp"
#include "python/bindings/plant.hpp"
#include "python/bindings/state.hpp"

using namespace plant;

namespace {

// Five numbers of a sequence or an array.
Joints joints(const py::object& torques) {
  try {
    return torques.cast<Joints>();
  } catch (const py::cast_error&) {
    throw py::value_error("five torques are needed (gantry, slew, luff, hoist, rotator), not " +
                          std::string(py::repr(torques)));
  }
}

void run(CraneAlone& crane, const py::object& torques, double dt, long steps) {
  if (steps < 0) throw py::value_error("steps must not be negative (got " + std::to_string(steps) + ")");
  const Joints torque = joints(torques);
  const py::gil_scoped_release release;
  for (long i = 0; i < steps; ++i) crane.step(torque, dt);
}

void bind_crane_alone(py::module_& m) {
  py::class_<CraneAlone::State>(m, "CraneAloneState",
                                "Everything that the crane's future depends on; opaque: to be read only.")
      .def_property_readonly("time", [](const CraneAlone::State& s) { return s.time; })
      .def("__copy__", [](const CraneAlone::State& s) { return s; })
      .def("__deepcopy__", [](const CraneAlone::State& s, const py::dict&) { return s; })
      .def(py::pickle(&value_bytes<CraneAlone::State>, &value_of_bytes<CraneAlone::State>));
  py::class_<CraneAlone>(m, "CraneAlone", "A crane by itself, driven by motor torques.")
      .def(py::init([](CraneParameters crane, const CranePose& home, double mass, double inertia, double rated_load,
                       bool rigid, double tolerance, Method method, int order, bool bookkeeping,
                       const SensorParameters& sensors, const WindParameters& wind) {
             crane.rated_load = rated_load;
             return std::make_unique<CraneAlone>(CraneAloneConfig{
                 crane, home, {mass, inertia}, rigid, tolerance, method, order, bookkeeping, sensors, wind});
           }),
           py::arg("crane"), py::arg("home"), py::arg("mass"), py::arg("inertia"), py::arg("rated_load"),
           py::arg("rigid"), py::arg("tolerance"), py::arg("method"), py::arg("order"), py::arg("bookkeeping"),
           py::arg("sensors"), py::arg("wind"))
      .def(
          "step", [](CraneAlone& c, const py::object& torques, double dt) { c.step(joints(torques), dt); },
          py::arg("torques"), py::arg("dt"))
      .def("run", &run, py::arg("torques"), py::arg("dt"), py::arg("steps"))
      .def(
          "set_load", [](CraneAlone& c, double mass, double inertia) { c.set_load({mass, inertia}); }, py::arg("mass"),
          py::arg("inertia"))
      .def("reset", &CraneAlone::reset, py::arg("q"), py::arg("qd"), py::arg("torque") = Joints{})
      .def("linearize", &CraneAlone::linearize, py::arg("state"))
      .def("snapshot", [](const CraneAlone& c) { return c.state(); })
      .def("restore", &CraneAlone::restore, py::arg("state"))
      .def_property_readonly("q", [](const CraneAlone& c) { return c.state().crane.q; })
      .def_property_readonly("qd", [](const CraneAlone& c) { return c.state().crane.qd; })
      .def_property_readonly("torque", [](const CraneAlone& c) { return c.state().crane.torque; })
      .def_property_readonly("time", [](const CraneAlone& c) { return c.state().time; })
      .def_property_readonly("faulted", [](const CraneAlone& c) { return c.state().faulted; })
      .def_property_readonly("at_limit", [](const CraneAlone& c) { return c.state().modes.at_limit; })
      .def_property_readonly("stuck", [](const CraneAlone& c) { return c.state().modes.stuck; })
      .def_property_readonly("work", [](const CraneAlone& c) { return c.state().work; })
      .def_property_readonly("events",
                             [](const CraneAlone& c) {
                               static constexpr std::array names{"limit", "stuck", "slipped", "slack", "swung_out"};
                               std::vector<std::tuple<std::int64_t, std::string, int>> all;
                               for (const auto& e : c.events())
                                 all.emplace_back(e.time, names.at(static_cast<std::size_t>(e.kind)), e.joint);
                               return all;
                             })
      .def_property_readonly("swung_out", [](const CraneAlone& c) { return c.state().swung_out; })
      .def_property_readonly("payload",
                             [](const CraneAlone& c) {
                               return std::pair{c.state().inputs.payload.mass, c.state().inputs.payload.inertia};
                             })
      .def_property_readonly("model", [](const CraneAlone& c) { return c.crane(); })
      .def("acceleration", &CraneAlone::acceleration)
      .def("energy", &CraneAlone::energy)
      .def("encoders", &CraneAlone::encoders)
      .def("sway", &CraneAlone::sway)
      .def(
          "sensitivity",
          [](const CraneAlone& c, const py::object& torques, double seconds) {
            const CraneSensitivity s = c.sensitivity(joints(torques), seconds);
            return std::tuple{s.q_by_mass, s.qd_by_mass, s.q_by_length, s.qd_by_length};
          },
          py::arg("torques"), py::arg("seconds"));
}

void bind_agv_alone(py::module_& m) {
  py::class_<AgvAlone::State>(m, "AgvAloneState", "Everything that a vehicle's future depends on; opaque.")
      .def("__copy__", [](const AgvAlone::State& s) { return s; })
      .def("__deepcopy__", [](const AgvAlone::State& s, const py::dict&) { return s; })
      .def(py::pickle(&value_bytes<AgvAlone::State>, &value_of_bytes<AgvAlone::State>));
  py::class_<AgvAlone>(m, "AgvAlone", "An AGV without a dock.")
      .def(py::init<const AgvParameters&, const Pose&, double>(), py::arg("parameters"), py::arg("start"),
           py::arg("tolerance") = 1e-8)
      .def(
          "step",
          [](AgvAlone& a, double speed, double front, double rear, double turn, double dt) {
            a.step({speed, front, rear, turn}, dt);
          },
          py::arg("speed"), py::arg("front"), py::arg("rear"), py::arg("turn"), py::arg("dt"))
      .def("set_load", &AgvAlone::set_load, py::arg("mass"), py::arg("inertia"))
      .def("reset", &AgvAlone::reset, py::arg("pose"))
      .def_property_readonly("y", [](const AgvAlone& a) { return a.state().vehicle.y; })
      .def_property_readonly("standing", [](const AgvAlone& a) { return a.state().vehicle.standing; })
      .def_property_readonly("time", [](const AgvAlone& a) { return a.state().time.count(); })
      .def("snapshot", [](const AgvAlone& a) { return a.state(); })
      .def("restore", &AgvAlone::restore, py::arg("state"))
      .def("energy", &AgvAlone::energy);
}

}  // namespace

void bind_plant_alone(py::module_& m) {
  bind_crane_alone(m);
  bind_agv_alone(m);
}
