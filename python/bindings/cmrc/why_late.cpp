// What is derived from whole runs.
#include <pybind11/stl.h>

#include "cmrc/run/compare_with_ideal.hpp"
#include "python/bindings/cmrc/on_progress.hpp"
#include "python/bindings/interpreter/ctrl_c.hpp"

void bind_why_late(py::module_& core) {
  using namespace py::literals;
  py::module_ m = core.def_submodule("why_late", "What a miss costs (docs/report.md).");
  m.def(
      "compare",
      [](const cmrc::Config& config, const py::object& on_progress) {
        OnProgress callback(on_progress);
        const report::Comparison comparison =
            interruptible_without_gil([&] { return cmrc::compare_with_ideal(config, callback.call()); });
        callback.raise();
        return std::pair(to_text(comparison), to_json(comparison));
      },
      "config"_a, "on_progress"_a = py::none(),
      "Text and JSON of a run beside its ideal; on_progress as of Simulation.run.");
}
