// What a run makes of its configuration before it begins: the DSPs' program, the dock.
#include "cmrc/configuration/config.hpp"
#include "cmrc/programs/dsp_image.hpp"
#include "cmrc/programs/segment_duration.hpp"
#include "cmrc/run/setup.hpp"
#include "cmrc/tasks/words.hpp"
#include "plant/dock/dock.hpp"
#include "tests/bindings/bindings.hpp"
#include "toolchain/objects/image.hpp"

void bind_run_setup(py::module_& test) {
  py::module_ m = test.def_submodule("run_setup", "What a run makes of its configuration before it begins.");
  m.def("dsp_image", &cmrc::dsp_image, py::arg("config"),
        "The DSPs' program as a run loads it, with what it knows of the plant in place: a toolchain.Image.");
  m.def(
      "segment_seconds",
      [](const cmrc::Config& config, double plan, double height, double turn) {
        return cmrc::SegmentDuration(cmrc::dsp_image(config), config).seconds(plan, height, turn);
      },
      py::arg("config"), py::arg("plan"), py::arg("height"), py::arg("turn"),
      "How long a slewing crane's trajectory takes for a segment, before a look-ahead stretches it: m, m, rad.");
  m.def(
      "dock_of",
      [](const cmrc::Config& config) {
        const toolchain::Image image = cmrc::dsp_image(config);
        return cmrc::dock_of(config, image, cmrc::Words([&](std::string_view name) { return image.symbol(name); }));
      },
      py::arg("config"), "The dock of a run: a plant.DockConfig. Raises ConfigError as the run does.");
}
