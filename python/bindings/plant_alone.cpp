// A crane and an AGV by themselves, without a dock.
#include <pybind11/stl.h>

#include "io/stop.hpp"
#include "plant/crane/crane_alone.hpp"
#include "plant/vehicles/agv_alone.hpp"
#include "python/bindings/ctrl_c.hpp"
#include "python/bindings/one_user.hpp"
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

/// Calls from two threads at once are refused.
class PythonCrane {
 public:
  explicit PythonCrane(const CraneAloneConfig& config) : crane_(config) {}
  const CraneAlone& read(const char* call) const {
    user_.reads(call);
    return crane_;
  }
  CraneAlone& change(const char* call) {
    user_.changes(call);
    return crane_;
  }
  /// Ctrl-C ends it between two steps.
  void run(const Joints& torque, double dt, long steps) {
    const OneUser::Long use(user_, "run", false);
    interruptible_without_gil([&] {
      for (long i = 0; i < steps && !io::stop_asked(); ++i) crane_.step(torque, dt);
    });
  }

 private:
  CraneAlone crane_;
  OneUser user_{"Crane"};
};

void run(PythonCrane& crane, const py::object& torques, double dt, long steps) {
  if (steps < 0) throw py::value_error("steps must not be negative (got " + std::to_string(steps) + ")");
  crane.run(joints(torques), dt, steps);
}

void bind_crane_alone(py::module_& m) {
  py::class_<CraneAlone::State>(m, "CraneAloneState",
                                "Everything that the crane's future depends on; opaque: to be read only.")
      .def_property_readonly("time", [](const CraneAlone::State& s) { return s.time; })
      .def("__copy__", [](const CraneAlone::State& s) { return s; })
      .def("__deepcopy__", [](const CraneAlone::State& s, const py::dict&) { return s; })
      .def(py::pickle(&value_bytes<CraneAlone::State>, &value_of_bytes<CraneAlone::State>));
  py::class_<PythonCrane>(m, "CraneAlone", "A crane by itself, driven by motor torques.")
      .def(py::init([](CraneParameters crane, const CranePose& home, double mass, double inertia, double rated_load,
                       bool rigid, double tolerance, Method method, int order, bool bookkeeping,
                       const SensorParameters& sensors, const WindParameters& wind) {
             crane.rated_load = rated_load;
             return std::make_unique<PythonCrane>(CraneAloneConfig{
                 crane, home, {mass, inertia}, rigid, tolerance, method, order, bookkeeping, sensors, wind});
           }),
           py::arg("crane"), py::arg("home"), py::arg("mass"), py::arg("inertia"), py::arg("rated_load"),
           py::arg("rigid"), py::arg("tolerance"), py::arg("method"), py::arg("order"), py::arg("bookkeeping"),
           py::arg("sensors"), py::arg("wind"))
      .def(
          "step",
          [](PythonCrane& c, const py::object& torques, double dt) { c.change("step").step(joints(torques), dt); },
          py::arg("torques"), py::arg("dt"))
      .def("run", &run, py::arg("torques"), py::arg("dt"), py::arg("steps"))
      .def(
          "set_load",
          [](PythonCrane& c, double mass, double inertia) { c.change("set_load").set_load({mass, inertia}); },
          py::arg("mass"), py::arg("inertia"))
      .def(
          "reset",
          [](PythonCrane& c, const CraneVector& q, const CraneVector& qd, const Joints& torque) {
            c.change("reset").reset(q, qd, torque);
          },
          py::arg("q"), py::arg("qd"), py::arg("torque") = Joints{})
      .def(
          "linearize",
          [](const PythonCrane& c, const CraneAlone::State& state) { return c.read("linearize").linearize(state); },
          py::arg("state"))
      .def("snapshot", [](const PythonCrane& c) { return c.read("snapshot").state(); })
      .def(
          "restore", [](PythonCrane& c, const CraneAlone::State& state) { c.change("restore").restore(state); },
          py::arg("state"))
      .def_property_readonly("q", [](const PythonCrane& c) { return c.read("q").state().crane.q; })
      .def_property_readonly("qd", [](const PythonCrane& c) { return c.read("qd").state().crane.qd; })
      .def_property_readonly("torque", [](const PythonCrane& c) { return c.read("torque").state().crane.torque; })
      .def_property_readonly("time", [](const PythonCrane& c) { return c.read("time").state().time; })
      .def_property_readonly("faulted", [](const PythonCrane& c) { return c.read("faulted").state().faulted; })
      .def_property_readonly("at_limit", [](const PythonCrane& c) { return c.read("at_limit").state().modes.at_limit; })
      .def_property_readonly("stuck", [](const PythonCrane& c) { return c.read("stuck").state().modes.stuck; })
      .def_property_readonly("work", [](const PythonCrane& c) { return c.read("work").state().work; })
      .def_property_readonly("events",
                             [](const PythonCrane& c) {
                               static constexpr std::array names{"limit", "stuck", "slipped", "slack", "swung_out"};
                               std::vector<std::tuple<std::int64_t, std::string, int>> all;
                               for (const auto& e : c.read("events").events())
                                 all.emplace_back(e.time, names.at(static_cast<std::size_t>(e.kind)), e.joint);
                               return all;
                             })
      .def_property_readonly("swung_out", [](const PythonCrane& c) { return c.read("swung_out").state().swung_out; })
      .def_property_readonly("payload",
                             [](const PythonCrane& c) {
                               return std::pair{c.read("payload").state().inputs.payload.mass,
                                                c.read("payload").state().inputs.payload.inertia};
                             })
      .def_property_readonly("model", [](const PythonCrane& c) { return c.read("model").crane(); })
      .def("acceleration", [](const PythonCrane& c) { return c.read("acceleration").acceleration(); })
      .def("energy", [](const PythonCrane& c) { return c.read("energy").energy(); })
      .def("encoders", [](const PythonCrane& c) { return c.read("encoders").encoders(); })
      .def("sway", [](const PythonCrane& c) { return c.read("sway").sway(); })
      .def(
          "sensitivity",
          [](const PythonCrane& c, const py::object& torques, double seconds) {
            const CraneSensitivity s = c.read("sensitivity").sensitivity(joints(torques), seconds);
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
