// A crane and an AGV by themselves, without a dock.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <string>
#include <string_view>
#include <vector>

#include "io/stop.hpp"
#include "plant/crane/crane_alone.hpp"
#include "plant/vehicles/agv_alone.hpp"
#include "python/bindings/interpreter/ctrl_c.hpp"
#include "python/bindings/interpreter/one_user.hpp"
#include "python/bindings/interpreter/state.hpp"
#include "python/bindings/plant/plant.hpp"

using namespace plant;

namespace {

/// What a crane or a vehicle is, part by part: what has to be the same for a snapshot to fit. Its place at the start
/// and its load are state.
struct Part {
  std::string name, value;
};
using Parts = std::vector<Part>;

Parts parts_of(const CraneAloneConfig& c) {
  return {{"machine", state::save_value(c.crane.machine)},
          {"parameter or drive", state::save_value(c.crane)},
          {"model", state::save_value(c.rigid)},
          {"integrator", state::save_value(c.method)},
          {"order", state::save_value(c.order)},
          {"tolerance", state::save_value(c.tolerance)},
          {"bookkeeping", state::save_value(c.bookkeeping)},
          {"seed or sway_noise", state::save_value(c.sensors)},
          {"wind", state::save_value(c.wind)}};
}
Parts parts_of(const AgvParameters& p, double tolerance) {
  return {{"drive", state::save_value(p.drive)},
          {"parameter", state::save_value(p)},
          {"tolerance", state::save_value(tolerance)}};
}

/// A state with what it is a state of.
template <class State>
struct Snapshot {
  Parts parts;
  State state;
};

template <class State>
const State& state_for(const Parts& parts, const Snapshot<State>& snapshot, const char* what) {
  for (std::size_t n = 0; n < parts.size(); ++n)
    if (n >= snapshot.parts.size() || snapshot.parts[n].value != parts[n].value)
      throw py::value_error(
          fmt::format("the snapshot is of {} with another {}; one of {} with the same config is expected", what,
                      parts[n].name, what));
  return snapshot.state;
}

// Five numbers of a sequence or an array, as plant/arguments.py takes them; lists, tuples and arrays need no look
// there.
Joints joints(const py::object& torques) {
  PyObject* const given = torques.ptr();
  const bool usual = PyList_CheckExact(given) || PyTuple_CheckExact(given) ||
                     std::string_view(Py_TYPE(given)->tp_name) == "numpy.ndarray";
  try {
    return (usual ? torques : py::module_::import("cmrc.plant.arguments").attr("array")(torques)).cast<Joints>();
  } catch (const py::cast_error&) {
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_TypeError)) throw;  // an array without dimensions has no length
  }
  throw py::value_error("five torques are needed (gantry, slew, luff, hoist, rotator), not " +
                        std::string(py::repr(torques)));
}

/// Calls from two threads at once are refused.
class PythonCrane {
 public:
  explicit PythonCrane(const CraneAloneConfig& config) : crane_(config), parts_(parts_of(config)) {}
  const CraneAlone& read(const char* call) const {
    user_.reads(call);
    return crane_;
  }
  CraneAlone& change(const char* call) {
    user_.changes(call);
    return crane_;
  }
  Snapshot<CraneAlone::State> snapshot() const { return {parts_, read("snapshot").state()}; }
  /// The state in a snapshot of a crane with the same config. \throws py::value_error
  const CraneAlone::State& state_in(const Snapshot<CraneAlone::State>& snapshot) const {
    return state_for(parts_, snapshot, "a crane");
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
  Parts parts_;
  OneUser user_{"Crane"};
};

void run(PythonCrane& crane, const py::object& torques, double dt, long steps) {
  if (steps < 0) throw py::value_error("steps must not be negative (got " + std::to_string(steps) + ")");
  crane.run(joints(torques), dt, steps);
}

template <class State>
py::class_<Snapshot<State>> bind_snapshot(py::module_& m, const char* name, const char* text) {
  using S = Snapshot<State>;
  return py::class_<S>(m, name, text)
      .def("__copy__", [](const S& s) { return s; })
      .def("__deepcopy__", [](const S& s, const py::dict&) { return s; })
      .def(py::pickle(&value_bytes<S>, &value_of_bytes<S>));
}

void bind_crane_alone(py::module_& m) {
  using CraneSnapshot = Snapshot<CraneAlone::State>;
  bind_snapshot<CraneAlone::State>(m, "CraneAloneState",
                                   "Everything that the crane's future depends on; opaque: to be read only.")
      .def_property_readonly("time", [](const CraneSnapshot& s) { return s.state.time; });
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
          [](const PythonCrane& c, const CraneSnapshot& state) {
            return c.read("linearize").linearize(c.state_in(state));
          },
          py::arg("state"))
      .def("snapshot", &PythonCrane::snapshot)
      .def(
          "restore", [](PythonCrane& c, const CraneSnapshot& state) { c.change("restore").restore(c.state_in(state)); },
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

struct PythonAgv : AgvAlone {
  PythonAgv(const AgvParameters& parameters, const Pose& start, double tolerance)
      : AgvAlone(parameters, start, tolerance), parts(parts_of(parameters, tolerance)) {}
  Parts parts;
};

void bind_agv_alone(py::module_& m) {
  using AgvSnapshot = Snapshot<AgvAlone::State>;
  bind_snapshot<AgvAlone::State>(m, "AgvAloneState", "Everything that a vehicle's future depends on; opaque.");
  py::class_<PythonAgv>(m, "AgvAlone", "An AGV without a dock.")
      .def(py::init<const AgvParameters&, const Pose&, double>(), py::arg("parameters"), py::arg("start"),
           py::arg("tolerance") = 1e-8)
      .def(
          "step",
          [](PythonAgv& a, double speed, double front, double rear, double turn, double dt) {
            a.step({speed, front, rear, turn}, dt);
          },
          py::arg("speed"), py::arg("front"), py::arg("rear"), py::arg("turn"), py::arg("dt"))
      .def("set_load", &AgvAlone::set_load, py::arg("mass"), py::arg("inertia"))
      .def("reset", &AgvAlone::reset, py::arg("pose"))
      .def_property_readonly("y", [](const PythonAgv& a) { return a.state().vehicle.y; })
      .def_property_readonly("standing", [](const PythonAgv& a) { return a.state().vehicle.standing; })
      .def_property_readonly("time", [](const PythonAgv& a) { return a.state().time.count(); })
      .def("snapshot", [](const PythonAgv& a) { return AgvSnapshot{a.parts, a.state()}; })
      .def(
          "restore", [](PythonAgv& a, const AgvSnapshot& state) { a.restore(state_for(a.parts, state, "an AGV")); },
          py::arg("state"))
      .def("energy", &AgvAlone::energy);
}

}  // namespace

void bind_plant_alone(py::module_& m) {
  bind_crane_alone(m);
  bind_agv_alone(m);
}
