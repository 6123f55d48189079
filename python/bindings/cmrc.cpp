#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "cmrc/configuration/config.hpp"
#include "cmrc/measures/ledger.hpp"
#include "cmrc/processes/consents.hpp"
#include "cmrc/processes/container_cycles.hpp"
#include "cmrc/run/reference_run.hpp"
#include "cmrc/run/setup.hpp"
#include "cmrc/run/simulation.hpp"
#include "cmrc/run/snapshot_origin.hpp"
#include "cmrc/tasks/importance.hpp"
#include "cmrc/tasks/task_list.hpp"
#include "cmrc/tasks/ti_float.hpp"
#include "machine/machine.hpp"
#include "plant/dock/dock.hpp"
#include "python/bindings/bindings.hpp"
#include "python/bindings/cmrc.hpp"
#include "python/bindings/errors.hpp"
#include "report/run_report.hpp"
#include "report/version.hpp"
#include "toolchain/objects/image.hpp"

namespace {

py::object to_python(const cmrc::Value& value) {
  return std::visit([](const auto& v) { return py::cast(v); }, value);
}

cmrc::Value to_value(const py::handle& value, const std::string& key) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::isinstance<py::float_>(value)) return value.cast<double>();
  if (PyIndex_Check(value.ptr()) != 0) {  // int and NumPy's integers
    const py::object index = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
    try {
      return index.cast<std::int64_t>();
    } catch (const py::cast_error&) {
      throw cmrc::ConfigError(key + ": " + std::string(py::str(value)) +
                              " does not fit 64 bits; a smaller integer is expected");
    }
  }
  if (py::hasattr(value, "__float__")) return py::float_(py::reinterpret_borrow<py::object>(value)).cast<double>();
  throw cmrc::ConfigError(key + ": " + std::string(py::str(py::type::of(value))) +
                          " cannot be used; a bool, int, float or str is expected");
}

/// Nested dictionaries are tables; a flat dictionary of dotted or unambiguous names works too.
void add_settings(cmrc::ConfigBuilder& builder, const py::dict& settings, const std::string& prefix) {
  for (const auto& [name, value] : settings) {
    const std::string key = prefix + std::string(py::str(name));
    if (py::isinstance<py::dict>(value)) {
      add_settings(builder, value.cast<py::dict>(), key + ".");
    } else {
      builder.set(key, to_value(value, key), {});
    }
  }
}

}  // namespace

cmrc::TimedEvent event_of(const py::dict& fields) {
  std::map<std::string, cmrc::Field> all;
  for (const auto& [name, value] : fields) {
    const std::string key = py::str(name);
    all[key] = {to_value(value, key), {}};
  }
  return cmrc::timed_event(all, {});
}

namespace {

void bind_config(py::module_& m) {
  m.attr("emulator_version") = report::emulator_version;
  python::register_error<cmrc::ConfigError>(m, "ConfigError", PyExc_ValueError);

  py::class_<cmrc::Config>(m, "Config", "All parameters of a run (docs/configuration.md).")
      .def(
          "to_toml", [](const cmrc::Config& config) { return cmrc::to_toml(config); },
          "The configuration as complete TOML.")
      .def(
          "to_dict",
          [](const cmrc::Config& config) {
            py::dict all;
            for (const cmrc::Key& key : cmrc::keys()) all[py::str(key.name)] = to_python(key.read(config));
            return all;
          },
          "Every key with its value.")
      .def(
          "intervals",
          [](const cmrc::Config& config) {
            const cmrc::Intervals n = cmrc::intervals(config);
            return py::dict(py::arg("N_p") = n.servo, py::arg("N_t") = n.crane_point, py::arg("N_a") = n.agv_point,
                            py::arg("N_a_slowed") = n.agv_slowed);
          },
          "Equations (5) and (6), in refreshes.");

  m.def("dsp_image", &cmrc::dsp_image, py::arg("config"),
        "The DSPs' program as a run loads it, with what it knows of the plant in place: a toolchain.Image.");
  m.def("run_key", &cmrc::result_key_of, py::arg("config"),
        "What makes a run's result, as TOML: the configuration but turn order, strictness and the paths of files.");
  m.def("reference_key", &cmrc::reference_key, py::arg("config"), "Equal for runs that may share one ideal run.");
  m.def(
      "beginning_of",
      [](const cmrc::Config& config, double time_s) { return cmrc::beginning_of(config, to_time("time_s", time_s)); },
      py::arg("config"), py::arg("time_s"), "The configuration without its events from that instant on.");
  m.def("inputs_of", &cmrc::inputs_of, py::arg("config"),
        "What a configuration says of the files that it needs, empty where it needs none: equal for equal files.");
  m.def("inputs_digest", &cmrc::digest_of_inputs, py::arg("config"),
        "SHA-256 of those files: the DSPs' program as assembled, layout, board.");
  m.def("dock_of", &cmrc::dock_of, py::arg("config"), "The dock of a run: a plant.DockConfig.");
  m.def(
      "config",
      [](const py::object& toml, const std::string& name, const py::object& file, const py::object& preset,
         const py::dict& settings, const std::vector<py::dict>& events) {
        cmrc::ConfigBuilder builder;
        if (!file.is_none()) builder.file(py::str(file));
        if (!toml.is_none()) builder.text(toml.cast<std::string>(), name);
        if (!preset.is_none()) builder.preset(preset.cast<std::string>(), {});
        add_settings(builder, settings, "");
        for (const py::dict& event : events) builder.event(event_of(event));
        return builder.build();
      },
      py::arg("toml") = py::none(), py::arg("name") = "<toml>", py::arg("file") = py::none(),
      py::arg("preset") = py::none(), py::arg("settings") = py::dict(), py::arg("events") = std::vector<py::dict>{},
      "Defaults, then the preset, the file, the TOML text, the settings. Raises ConfigError.");

  m.def(
      "config_keys",
      [] {
        py::list all;
        const cmrc::Config defaults;
        for (const cmrc::Key& key : cmrc::keys()) {
          py::dict entry;
          entry["name"] = key.name;
          entry["type"] = std::string(cmrc::name(key.type));
          entry["unit"] = key.unit;
          entry["minimum"] = key.minimum;
          entry["maximum"] = key.maximum;
          entry["choices"] = key.choices;
          entry["default"] = to_python(key.read(defaults));
          entry["meaning"] = key.meaning;
          entry["source"] = key.source;
          entry["live"] = key.live;
          all.append(entry);
        }
        return all;
      },
      "The schema: one dictionary per key.");

  m.def(
      "timed_actions",
      [] {
        py::list all;
        for (const cmrc::TimedAction& action : cmrc::timed_actions()) {
          all.append(py::dict(
              py::arg("name") = std::string(action.name), py::arg("target") = std::string(action.target),
              py::arg("amount") = std::string(action.amount), py::arg("meaning") = std::string(action.meaning)));
        }
        return all;
      },
      "What [[events]] can do.");

  m.def("presets", [] {
    py::dict all;
    for (const cmrc::Preset& preset : cmrc::presets())
      all[py::str(std::string(preset.name))] = std::string(preset.meaning);
    return all;
  });
}

cmrc::ImportanceParameters to_parameters(const py::dict& values) {
  cmrc::ImportanceParameters n;
  const std::map<std::string, std::int64_t*> fields = {
      {"N_p", &n.n_servo}, {"N_t", &n.n_crane}, {"N_a", &n.n_agv}, {"gamma", &n.gamma}, {"alpha", &n.alpha},
      {"beta", &n.beta},   {"p", &n.p},         {"q", &n.q},       {"b", &n.b},         {"a", &n.a}};
  for (const auto& [key, value] : values) {
    const std::string name = py::str(key);
    if (name == "as_printed")
      n.equation = value.cast<bool>() ? cmrc::Equation7::as_printed : cmrc::Equation7::restored;
    else
      *fields.at(name) = value.cast<std::int64_t>();
  }
  return n;
}

/// The abstract machine of plant-and-bus.md 4.8 on the host's own list: durations in ticks, N DSPs that take from the
/// top at each refresh, an interpolation buffer of depth 1 of which no point is consumed. What it shows is the
/// scheduling rule alone.
class TickTable {
 public:
  struct Kind {
    std::string name;
    std::uint32_t x, y;
    std::int64_t duration;
    bool servo;             // reloads itself and inherits t
    std::string successor;  // loaded when it is done
  };

  TickTable(const py::dict& parameters, const py::list& tasks, std::size_t dsps)
      : parameters_(to_parameters(parameters)), list_(64), dsps_(dsps) {
    for (const py::handle& row : tasks) {
      const auto [name, x, y, duration, servo, successor] =
          row.cast<std::tuple<std::string, std::uint32_t, std::uint32_t, std::int64_t, bool, std::string>>();
      kinds_.push_back({name, x, y, duration, servo, successor});
    }
  }

  void load(const std::string& name, std::int64_t t) {
    const auto kind = std::find_if(kinds_.begin(), kinds_.end(), [&](const Kind& k) { return k.name == name; });
    const auto index = static_cast<std::uint32_t>(kind - kinds_.begin());
    list_.load({.x = kind->x, .y = kind->y, .kind = index, .t = t});
  }

  /// One refresh and what the DSPs then take. \returns "name:t:J" by falling J, with a star when running.
  std::vector<std::string> tick() {
    for (Dsp& dsp : dsps_) {
      if (!dsp.busy || --dsp.left > 0) continue;
      dsp.busy = false;
      const Kind& kind = kinds_[list_[dsp.block].task.kind];
      const std::int64_t t = list_[dsp.block].t;
      list_.remove(dsp.block);
      if (kind.servo) load(kind.name, t);
      if (!kind.successor.empty()) load(kind.successor, 0);
    }
    list_.refresh(1, [this](const cmrc::TaskBlock& block) {
      return cmrc::importance(parameters_, block.task.x, block.task.y, block.t);
    });
    for (Dsp& dsp : dsps_) {
      if (dsp.busy) continue;
      for (const std::size_t index : list_.by_importance()) {
        if (list_[index].flag != cmrc::Flag::waiting || list_[index].importance == 0) continue;
        list_.take(index);
        dsp = {true, index, kinds_[list_[index].task.kind].duration};
        break;
      }
    }
    std::vector<std::string> shown;
    for (const std::size_t index : list_.by_importance()) {
      const cmrc::TaskBlock& block = list_[index];
      shown.push_back(fmt::format("{}:{}:{:X}{}", kinds_[block.task.kind].name, block.t, block.importance,
                                  block.flag == cmrc::Flag::taken ? "*" : ""));
    }
    return shown;
  }

 private:
  struct Dsp {
    bool busy = false;
    std::size_t block = 0;
    std::int64_t left = 0;
  };

  cmrc::ImportanceParameters parameters_;
  cmrc::TaskList list_;
  std::vector<Kind> kinds_;
  std::vector<Dsp> dsps_;
};

void bind_scheduling(py::module_& m) {
  m.def(
      "importance",
      [](std::uint32_t x, std::uint32_t y, std::int64_t t, const py::dict& parameters) {
        return cmrc::importance(to_parameters(parameters), x, y, t);
      },
      py::arg("x"), py::arg("y"), py::arg("t"), py::arg("parameters") = py::dict(), "Equation (7).");
  py::class_<TickTable>(m, "TickTable", "The scheduling rule on an abstract machine (plant-and-bus.md 4.8).")
      .def(py::init<const py::dict&, const py::list&, std::size_t>())
      .def("load", &TickTable::load)
      .def("tick", &TickTable::tick);
}

report::Time seconds(double s) { return report::Time{std::llround(s * 1e12)}; }

py::object to_seconds(const std::optional<report::Time>& time) {
  return time ? py::object(py::float_(static_cast<double>(time->count()) * 1e-12)) : py::none();
}

py::dict to_dict(const report::CycleReport& c) {
  return py::dict(py::arg("number") = c.number, py::arg("agv") = c.agv, py::arg("t3") = to_seconds(c.t3),
                  py::arg("t4") = to_seconds(c.t4), py::arg("t5") = to_seconds(c.t5), py::arg("t6") = to_seconds(c.t6),
                  py::arg("t_v") = to_seconds(c.t_v), py::arg("t_w") = to_seconds(c.t_w),
                  py::arg("t_wait") = to_seconds(c.t_wait), py::arg("T_g") = to_seconds(c.T_g),
                  py::arg("T_a") = to_seconds(c.T_a));
}

/// The ledger with times in seconds and one cause, for tests of the classes of ruling 16.
class TestLedger {
 public:
  void release(std::size_t block, const std::string& kind, double released, const std::optional<double>& deadline) {
    ledger_.release(block, index_of(kind), seconds(released),
                    deadline ? std::optional(seconds(*deadline)) : std::nullopt, std::nullopt);
  }
  void skipped(const std::string& kind, double released, double deadline, std::int64_t tick) {
    ledger_.skipped(index_of(kind), seconds(released), seconds(deadline), tick, seconds(released));
  }
  void claimed(std::size_t block, unsigned slot, double at, const std::vector<std::int64_t>& causes) {
    ledger_.claimed(block, slot, seconds(at), causes);
  }
  void finished(std::size_t block, unsigned slot, double at, const std::vector<std::int64_t>& causes) {
    ledger_.finished(block, slot, seconds(at), causes);
  }
  void put_back(std::size_t block, double at) { ledger_.put_back(block, seconds(at)); }
  void dropped(std::size_t block, double at) { ledger_.dropped(block, seconds(at)); }
  void removed(std::size_t block) { ledger_.removed(block); }
  void slot_failed(unsigned slot) { ledger_.slot_failed(slot, {}); }
  std::vector<std::string> violations() const { return ledger_.audit().violations(); }
  py::dict report(double now) const {
    py::dict all;
    for (const report::TaskReport& task : ledger_.tell(seconds(now), {}).tasks) {
      py::dict causes;
      for (const report::Share& share : task.execution_causes) causes[py::str(share.name)] = share.amount;
      all[py::str(task.kind)] =
          py::dict(py::arg("released") = task.released, py::arg("on_time") = task.on_time, py::arg("late") = task.late,
                   py::arg("unfinished") = task.unfinished, py::arg("never_started") = task.never_started,
                   py::arg("lost") = task.lost, py::arg("dropped") = task.dropped, py::arg("misses") = task.misses,
                   py::arg("causes") = causes, py::arg("worst_response") = task.response.worst);
    }
    return all;
  }

 private:
  static cmrc::JobKind index_of(const std::string& kind) {
    const auto kinds = cmrc::job_kinds();
    return static_cast<cmrc::JobKind>(std::find(kinds.begin(), kinds.end(), kind) - kinds.begin());
  }
  cmrc::Ledger ledger_{
      {.causes = {"execute", "bus"}, .booked = {}, .booked_as = {}, .servo_period = seconds(1e-3), .user_tasks = {}}};
};

void bind_parts(py::module_& m) {
  py::class_<cmrc::Consents>(m, "Consents", "May-load tokens (plant-and-bus.md 4.4 items 13 to 16).")
      .def(py::init([](unsigned agvs) { return cmrc::Consents(cmrc::built_in_processes(), agvs); }))
      .def("give", &cmrc::Consents::give, py::arg("source"), py::arg("target"), py::arg("agv") = 0)
      .def("clear", &cmrc::Consents::clear, py::arg("source"), py::arg("target"), py::arg("agv") = 0)
      .def("given", &cmrc::Consents::given, py::arg("source"), py::arg("target"), py::arg("agv") = 0)
      .def("all", &cmrc::Consents::all, py::arg("target"), py::arg("agv") = 0)
      .def("consume", &cmrc::Consents::consume, py::arg("target"), py::arg("agv") = 0);
  py::class_<cmrc::EventTimes>(m, "Instants",
                               "When something happened, again and again, in bounded memory; picoseconds.")
      .def(py::init<std::size_t, std::size_t>(), py::arg("kept_max"), py::arg("bins_max"))
      .def(
          "add", [](cmrc::EventTimes& instants, std::int64_t ps) { instants.add(cmrc::Time{ps}); }, py::arg("ps"))
      .def(
          "until", [](const cmrc::EventTimes& instants, std::int64_t ps) { return instants.until(cmrc::Time{ps}); },
          py::arg("ps"))
      .def_property_readonly("count", &cmrc::EventTimes::count)
      .def_property_readonly("bin_ps", [](const cmrc::EventTimes& instants) { return instants.bin().count(); })
      .def("in_order", [](const cmrc::EventTimes& instants) {
        std::vector<std::pair<std::int64_t, std::uint64_t>> all;
        for (const auto& some : instants.in_order()) all.emplace_back(some.time.count(), some.count);
        return all;
      });
  py::class_<cmrc::ContainerCycles>(m, "Cycles", "Times of the processes; seconds.")
      .def(py::init<>())
      .def("process",
           [](cmrc::ContainerCycles& c, unsigned number, bool started, unsigned robot, double now) {
             c.process(cmrc::built_in_processes().find(number)->account, started, robot, seconds(now));
           })
      .def("agv_waits", [](cmrc::ContainerCycles& c, unsigned agv, bool waits,
                           double now) { c.agv_waits(agv, waits, seconds(now)); })
      .def_property_readonly("completed", &cmrc::ContainerCycles::completed)
      .def("cycles", [](const cmrc::ContainerCycles& c) {
        py::list all;
        for (const auto& cycle : c.cycles()) all.append(to_dict(cycle));
        return all;
      });
  m.def(
      "learned_interval",
      [](const cmrc::Config&, const std::string& rule, std::int64_t present, std::int64_t lowest, unsigned agvs,
         double driving, double t_w, double t_v, double T_g) {
        cmrc::Config::Scheduling scheduling;
        scheduling.learning = rule == "unit"  ? cmrc::Learning::unit
                              : rule == "off" ? cmrc::Learning::off
                                              : cmrc::Learning::proportional;
        const cmrc::AgvCycle cycle{0, seconds(driving), seconds(t_w), seconds(t_v), seconds(T_g)};
        return cmrc::learned_interval(scheduling, present, lowest, agvs, cycle);
      },
      py::arg("config"), py::arg("rule"), py::arg("present"), py::arg("lowest"), py::arg("agvs"), py::arg("driving"),
      py::arg("t_w"), py::arg("t_v"), py::arg("T_g"), "N^_a after a cycle (plant-and-bus.md 4.7).");
  m.def("ti_float", &cmrc::ti_float, "A number in the C40's single format.");
  py::class_<cmrc::Liveness>(m, "Liveness", "Which DSPs give a sign of life; refreshes.")
      .def(py::init<>())
      .def("sign", &cmrc::Liveness::sign, py::arg("slot"), py::arg("refresh"))
      .def("signs", &cmrc::Liveness::signs, py::arg("mask"), py::arg("refresh"))
      .def("renewed", &cmrc::Liveness::renewed, py::arg("slot"), py::arg("refresh"))
      .def("doubtful", &cmrc::Liveness::doubtful, py::arg("refresh"), py::arg("limit"))
      .def(
          "judge",
          [](cmrc::Liveness& liveness, std::int64_t refresh, std::int64_t limit) {
            std::vector<std::pair<unsigned, std::string>> all;
            for (const auto& [slot, verdict] : liveness.judge(refresh, limit)) {
              all.emplace_back(slot, verdict == cmrc::Liveness::Verdict::silent ? "silent" : "dead");
            }
            return all;
          },
          py::arg("refresh"), py::arg("limit"));
  py::class_<TestLedger>(m, "Ledger", "The account of jobs; seconds.")
      .def(py::init<>())
      .def("release", &TestLedger::release, py::arg("block"), py::arg("kind"), py::arg("released"),
           py::arg("deadline") = py::none())
      .def("skipped", &TestLedger::skipped)
      .def("claimed", &TestLedger::claimed)
      .def("finished", &TestLedger::finished)
      .def("put_back", &TestLedger::put_back)
      .def("dropped", &TestLedger::dropped)
      .def("removed", &TestLedger::removed)
      .def("slot_failed", &TestLedger::slot_failed)
      .def("violations", &TestLedger::violations)
      .def("report", &TestLedger::report);
}

}  // namespace

void bind_cmrc(py::module_& core) {
  py::module_ m = core.def_submodule("cmrc", "The controller: configuration, importance, list, host, runs.");
  bind_config(m);
  bind_scheduling(m);
  bind_parts(m);
  bind_simulation(m);
}
