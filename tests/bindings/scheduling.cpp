// The rule of scheduling, the releases of sub-processes and the clocks of a run, without a run.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <map>

#include "cmrc/configuration/machine/clock_deviations.hpp"
#include "cmrc/processes/releases.hpp"
#include "cmrc/tasks/importance.hpp"
#include "cmrc/tasks/task_list.hpp"
#include "tests/bindings/bindings.hpp"

namespace {

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
      for (const std::size_t index : by_importance()) {
        if (list_[index].flag != cmrc::Flag::waiting || list_[index].importance == 0) continue;
        list_.take(index);
        dsp = {true, index, kinds_[list_[index].task.kind].duration};
        break;
      }
    }
    std::vector<std::string> shown;
    for (const std::size_t index : by_importance()) {
      const cmrc::TaskBlock& block = list_[index];
      shown.push_back(fmt::format("{}:{}:{:X}{}", kinds_[block.task.kind].name, block.t, block.importance,
                                  block.flag == cmrc::Flag::taken ? "*" : ""));
    }
    return shown;
  }

 private:
  /// The blocks by falling J alone, as the tables of plant-and-bus.md 4.8 show them; of equal J the one loaded first.
  std::vector<std::size_t> by_importance() const {
    std::vector<std::size_t> sorted(list_.order().begin(), list_.order().end());
    std::sort(sorted.begin(), sorted.end(), [this](std::size_t a, std::size_t b) {
      const cmrc::TaskBlock &one = list_[a], &other = list_[b];
      return one.importance != other.importance ? one.importance > other.importance : one.inserted < other.inserted;
    });
    return sorted;
  }

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

}  // namespace

void bind_scheduling(py::module_& test) {
  py::module_ m = test.def_submodule("scheduling", "Equation (7), the list, releases and clocks, each alone.");
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
}
