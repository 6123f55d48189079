// When sub-processes are released, and the clocks of a run: rules alone, without a run.
#include <pybind11/stl.h>

#include "cmrc/configuration/clock_deviations.hpp"
#include "cmrc/processes/releases.hpp"
#include "python/bindings/bindings.hpp"

void bind_releases(py::module_& core) {
  auto m = core.attr("cmrc").cast<py::module_>();
  m.def(
      "oscillators",
      [](const cmrc::Config& config) {
        py::list all;
        for (const cmrc::Oscillator& one : cmrc::oscillators_of(config).all()) {
          const machine::Clock nominal{one.hertz, one.per}, skewed = one.skew.clock(one.hertz, one.per);
          all.append(py::dict(py::arg("name") = one.name, py::arg("nominal_hz") = nominal.hertz(),
                              py::arg("ppm") = one.skew.ppm, py::arg("phase_ps") = one.skew.phase.count(),
                              py::arg("period_ps") = (skewed.at(1) - skewed.at(0)).count()));
        }
        return all;
      },
      py::arg("config"), "The clocks of a run (run.phase_jitter): one dictionary per oscillator.");
  m.def(
      "release_steps",
      [](const std::string& release, unsigned number, unsigned count, bool staggered,
         const std::vector<std::tuple<std::int64_t, std::int64_t, bool, bool, bool>>& steps) {
        cmrc::Subprocess row;
        row.release = release == "event"      ? cmrc::Subprocess::Release::event
                      : release == "interval" ? cmrc::Subprocess::Release::interval
                                              : cmrc::Subprocess::Release::interval_and_event;
        cmrc::Release one(row, number + 1, number, count);
        std::vector<std::pair<bool, std::vector<std::int64_t>>> all;
        for (const auto& [tick, period, runs, object, ended] : steps) {
          if (ended) one.ended();
          if (object) one.object_entered();
          if (!runs) one.rests(tick);
          const auto due = runs ? one.due(tick, period, staggered) : cmrc::Release::Due{};
          if (due.load) one.loaded(tick + period);
          all.emplace_back(due.load, due.dropped);
        }
        return all;
      },
      py::arg("release"), py::arg("number"), py::arg("count"), py::arg("staggered"), py::arg("steps"),
      "A sub-process of AGV `number` of `count`, refresh by refresh: (refresh, interval, runs, an object enters, its "
      "block has ended) -> (loaded, refreshes dropped).");
  m.def(
      "objects_entered",
      [](const std::vector<std::uint32_t>& readings, std::int64_t field_mm) {
        cmrc::RangeField field;
        std::vector<bool> all;
        for (const std::uint32_t mm : readings) all.push_back(field.entered(mm, {.every = 8, .field_mm = field_mm}));
        return all;
      },
      py::arg("readings"), py::arg("field_mm"),
      "Which readings of a range sensor, in mm, tell of an object that has entered its field.");
}
