#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>

#include "cmrc/config.hpp"
#include "cmrc/importance.hpp"
#include "cmrc/list.hpp"
#include "python/bindings/bindings.hpp"

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
      throw cmrc::ConfigError(key + ": " + std::string(py::str(value)) + " does not fit 64 bits; a smaller integer is expected");
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

void bind_config(py::module_& m) {
  py::register_exception<cmrc::ConfigError>(m, "ConfigError", PyExc_ValueError);

  py::class_<cmrc::Config>(m, "Config", "All parameters of a run (docs/configuration.md).")
      .def("to_toml", &cmrc::to_toml, "The configuration as complete TOML.")
      .def("to_dict", [](const cmrc::Config& config) {
        py::dict all;
        for (const cmrc::Key& key : cmrc::keys()) all[py::str(key.name)] = to_python(key.read(config));
        return all;
      }, "Every key with its value.")
      .def("intervals", [](const cmrc::Config& config) {
        const cmrc::Intervals n = cmrc::intervals(config);
        return py::dict(py::arg("N_p") = n.servo, py::arg("N_t") = n.crane_point, py::arg("N_a") = n.agv_point,
                        py::arg("N_a_slowed") = n.agv_slowed);
      }, "Equations (5) and (6), in refreshes.");

  m.def("config", [](const py::object& toml, const std::string& name, const py::object& file, const py::object& preset,
                     const py::dict& settings) {
    cmrc::ConfigBuilder builder;
    if (!file.is_none()) builder.file(py::str(file));
    if (!toml.is_none()) builder.text(toml.cast<std::string>(), name);
    if (!preset.is_none()) builder.preset(preset.cast<std::string>(), {});
    add_settings(builder, settings, "");
    return builder.build();
  }, py::arg("toml") = py::none(), py::arg("name") = "<toml>", py::arg("file") = py::none(),
     py::arg("preset") = py::none(), py::arg("settings") = py::dict(),
     "Defaults, then the preset, the file, the TOML text, the settings. Raises ConfigError.");

  m.def("config_keys", [] {
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
      all.append(entry);
    }
    return all;
  }, "The schema: one dictionary per key.");

  m.def("presets", [] {
    py::dict all;
    for (const cmrc::Preset& preset : cmrc::presets()) all[py::str(std::string(preset.name))] = std::string(preset.meaning);
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
    if (name == "as_printed") n.equation = value.cast<bool>() ? cmrc::Equation7::as_printed : cmrc::Equation7::restored;
    else *fields.at(name) = value.cast<std::int64_t>();
  }
  return n;
}

/// The abstract machine of plant-and-bus.md 4.8 on the host's own list: durations in ticks, N DSPs that take from the top at each
/// refresh, an interpolation buffer of depth 1 of which no point is consumed. What it shows is the scheduling rule alone.
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
    list_.refresh(1, [this](const cmrc::Block& block) {
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
      const cmrc::Block& block = list_[index];
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
  m.def("importance", [](std::uint32_t x, std::uint32_t y, std::int64_t t, const py::dict& parameters) {
    return cmrc::importance(to_parameters(parameters), x, y, t);
  }, py::arg("x"), py::arg("y"), py::arg("t"), py::arg("parameters") = py::dict(), "Equation (7).");
  py::class_<TickTable>(m, "TickTable", "The scheduling rule on an abstract machine (plant-and-bus.md 4.8).")
      .def(py::init<const py::dict&, const py::list&, std::size_t>())
      .def("load", &TickTable::load)
      .def("tick", &TickTable::tick);
}

}  // namespace

void bind_cmrc(py::module_& core) {
  py::module_ m = core.def_submodule("cmrc", "The controller: configuration, importance, list, host, runs.");
  bind_config(m);
  bind_scheduling(m);
}
