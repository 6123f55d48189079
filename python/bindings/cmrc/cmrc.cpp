#include <pybind11/stl.h>

#include <map>

#include "cmrc/configuration/config.hpp"
#include "cmrc/run/reference_run.hpp"
#include "cmrc/run/setup.hpp"
#include "cmrc/run/simulation.hpp"
#include "cmrc/run/snapshot_origin.hpp"
#include "python/bindings/bindings.hpp"
#include "python/bindings/cmrc/cmrc.hpp"
#include "python/bindings/interpreter/errors.hpp"
#include "python/bindings/interpreter/float_environment.hpp"
#include "report/version.hpp"

namespace {

py::object to_python(const cmrc::Value& value) {
  return std::visit([](const auto& v) { return py::cast(v); }, value);
}

cmrc::Value to_value(const py::handle& value, const std::string& key) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::isinstance<py::float_>(value)) return value.cast<double>();
  // int and NumPy's integers; of an array Python finds out only now that it is none
  if (const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()))) {
    try {
      return index.cast<std::int64_t>();
    } catch (const py::cast_error&) {
      throw cmrc::ConfigError(key + ": " + std::string(py::str(value)) +
                              " does not fit 64 bits; a smaller integer is expected");
    }
  }
  PyErr_Clear();
  const double number = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred() == nullptr) return number;
  PyErr_Clear();
  throw cmrc::ConfigError(key + ": " + std::string(py::str(py::type::of(value))) +
                          " cannot be used; a bool, int, float or str is expected");
}

/// Nested dictionaries are tables; a flat dictionary of dotted or unambiguous names works too.
void add_settings(cmrc::ConfigBuilder& builder, const py::dict& settings, const std::string& prefix) {
  for (const auto& [name, value] : settings) {
    const std::string key = prefix + name.cast<std::string>();
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
    const auto key = name.cast<std::string>();
    all[key] = {to_value(value, key), {}};
  }
  return cmrc::timed_event(all, {});
}

namespace {

std::string text_of(const std::string& argument, const py::object& given) {
  if (py::isinstance<py::str>(given)) return given.cast<std::string>();
  throw py::type_error(argument + ": " + std::string(py::repr(given)) + " (" +
                       std::string(py::str(py::type::of(given).attr("__name__"))) + "); a str is expected");
}

cmrc::ConfigBuilder layers_of(const py::object& toml, const std::string& name, const py::object& file,
                              const py::object& preset, const py::dict& settings, const std::vector<py::dict>& events) {
  cmrc::ConfigBuilder builder;
  if (!file.is_none()) builder.file(py::str(file).cast<std::string>());
  if (!toml.is_none()) builder.text(text_of("toml", toml), name);
  if (!preset.is_none()) builder.preset(text_of("preset", preset), {});
  add_settings(builder, settings, "");
  for (const py::dict& event : events) builder.event(event_of(event));
  return builder;
}

void bind_config(py::module_& m) {
  m.attr("emulator_version") = report::emulator_version;
  python::register_error<cmrc::ConfigError>(m, "ConfigError", PyExc_ValueError);
  python::register_error<cmrc::ListFull>(m, "ListFull", PyExc_RuntimeError);

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
  py::class_<cmrc::ConfigBuilder>(m, "ConfigLayers", "What a configuration is made of, with the places in its files.")
      .def(
          "config",
          [](const cmrc::ConfigBuilder& layers, const py::dict& settings) {
            cmrc::ConfigBuilder own = layers;
            add_settings(own, settings, "");
            return own.build();
          },
          py::arg("settings") = py::dict(), py::call_guard<UsualFloats>(),
          "The configuration, with further settings that override all. Raises ConfigError.");
  m.def("config_layers", &layers_of, py::arg("toml") = py::none(), py::arg("name") = "<toml>",
        py::arg("file") = py::none(), py::arg("preset") = py::none(), py::arg("settings") = py::dict(),
        py::arg("events") = std::vector<py::dict>{}, py::call_guard<UsualFloats>(),
        "The arguments of config, which is not made yet: files are read once, for several configurations.");
  m.def(
      "config",
      [](const py::object& toml, const std::string& name, const py::object& file, const py::object& preset,
         const py::dict& settings,
         const std::vector<py::dict>& events) { return layers_of(toml, name, file, preset, settings, events).build(); },
      py::arg("toml") = py::none(), py::arg("name") = "<toml>", py::arg("file") = py::none(),
      py::arg("preset") = py::none(), py::arg("settings") = py::dict(), py::arg("events") = std::vector<py::dict>{},
      py::call_guard<UsualFloats>(),
      "Defaults, then the preset, the file, the TOML text, the settings. Raises ConfigError.");

  m.def("right_key", &cmrc::right_key, py::arg("key"), "What would be right instead of this unknown key.");
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

}  // namespace

void bind_cmrc(py::module_& core) {
  py::module_ m = core.def_submodule("cmrc", "The controller: configuration and runs.");
  bind_config(m);
  bind_simulation(m);
}
