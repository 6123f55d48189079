// Chains of causes on a ledger that a test fills, and what is derived from whole runs.
#include <pybind11/stl.h>

#include <algorithm>
#include <stdexcept>

#include "cmrc/measures/ledger.hpp"
#include "cmrc/run/compare_with_ideal.hpp"
#include "python/bindings/ctrl_c.hpp"
#include "report/run_report.hpp"

namespace {

using report::Time;

/// The ledger with times in picoseconds, a clock of 1 THz (a cycle is a picosecond), and causes "execute" and "bus".
class Scene {
 public:
  explicit Scene(std::size_t kept)
      : ledger_({.causes = {"execute", "bus"},
                 .booked = {},
                 .booked_as = {},
                 .servo_period = {},
                 .user_tasks = {},
                 .chip_clock = machine::Clock(1'000'000'000'000),
                 .misses_kept = kept}) {}

  void release(std::size_t block, const std::string& kind, std::int64_t released, std::optional<std::int64_t> deadline,
               std::uint32_t robot) {
    ledger_.release(block, index_of(kind), Time{released}, deadline ? std::optional(Time{*deadline}) : std::nullopt,
                    std::nullopt, robot);
  }
  void skipped(const std::string& kind, std::int64_t released, std::int64_t deadline, std::int64_t tick,
               std::int64_t found) {
    ledger_.skipped(index_of(kind), Time{released}, Time{deadline}, tick, Time{found});
  }
  void refresh(std::int64_t began, std::int64_t wanted, std::int64_t held, std::int64_t freed,
               const std::vector<std::size_t>& offered) {
    ledger_.refresh_began(Time{began});
    ledger_.list_wanted(Time{wanted});
    ledger_.list_held(Time{held});
    for (const std::size_t block : offered) ledger_.offered(block);
    ledger_.list_freed(Time{freed});
  }
  void slot(unsigned slot, const std::string& state, std::int64_t at) {
    static const std::vector<std::string> states = {"off", "asleep", "awake"};
    const auto found = std::find(states.begin(), states.end(), state);
    if (found == states.end()) throw py::value_error("a state is off, asleep or awake");
    ledger_.timeline().slot(slot, static_cast<cmrc::SlotState>(found - states.begin()), Time{at});
  }
  void list(unsigned owner, std::int64_t at) { ledger_.timeline().list(owner, Time{at}); }
  void bus(unsigned slot, bool a, std::int64_t from, std::int64_t to) {
    ledger_.timeline().window(slot, a ? machine::Window::a : machine::Window::b, Time{from}, Time{to});
  }
  void claimed(std::size_t block, unsigned slot, std::int64_t at, const std::vector<std::int64_t>& causes) {
    ledger_.claimed(block, slot, Time{at}, causes);
  }
  void finished(std::size_t block, unsigned slot, std::int64_t at, const std::vector<std::int64_t>& causes) {
    ledger_.finished(block, slot, Time{at}, causes);
  }
  void put_back(std::size_t block, std::int64_t at) { ledger_.put_back(block, Time{at}); }
  void dropped(std::size_t block, std::int64_t at) { ledger_.dropped(block, Time{at}); }
  void removed(std::size_t block) { ledger_.removed(block); }
  void slot_failed(unsigned slot, std::int64_t at) { ledger_.slot_failed(slot, Time{at}); }
  std::string report_json(std::int64_t now, const std::vector<std::vector<std::int64_t>>& causes) const {
    cmrc::Ledger::Report told = ledger_.tell(
        Time{now}, [&](unsigned slot) { return slot < causes.size() ? causes[slot] : cmrc::CauseTimes{}; });
    report::RunReport run;
    run.tasks = std::move(told.tasks);
    run.missed = std::move(told.misses);
    run.misses_left_out = told.misses_left_out;
    run.audit = std::move(told.audit);
    return to_json(run);
  }

 private:
  static cmrc::JobKind index_of(const std::string& kind) {
    const auto kinds = cmrc::job_kinds();
    const auto found = std::find(kinds.begin(), kinds.end(), kind);
    if (found == kinds.end()) throw py::value_error("no such kind");
    return static_cast<cmrc::JobKind>(found - kinds.begin());
  }
  cmrc::Ledger ledger_;
};

}  // namespace

void bind_why_late(py::module_& core) {
  using namespace py::literals;
  py::module_ m = core.def_submodule("why_late", "Chains of causes, and what a miss costs (docs/report.md).");
  m.def(
      "compare",
      [](const cmrc::Config& config) {
        const report::Comparison comparison =
            interruptible_without_gil([&] { return cmrc::compare_with_ideal(config); });
        return std::pair(to_text(comparison), to_json(comparison));
      },
      "config"_a, "Text and JSON of a run beside its ideal.");
  py::class_<Scene>(m, "Scene", "A ledger whose events are told by hand; picoseconds.")
      .def(py::init<std::size_t>(), "kept"_a = 1000)
      .def("release", &Scene::release, "block"_a, "kind"_a, "released"_a, "deadline"_a = py::none(), "robot"_a = 0)
      .def("skipped", &Scene::skipped, "kind"_a, "released"_a, "deadline"_a, "tick"_a, "found"_a)
      .def("refresh", &Scene::refresh, "began"_a, "wanted"_a, "held"_a, "freed"_a, "offered"_a)
      .def("slot", &Scene::slot, "slot"_a, "state"_a, "at"_a)
      .def("list", &Scene::list, "owner"_a, "at"_a)
      .def("bus", &Scene::bus, "slot"_a, "a"_a, "start"_a, "end"_a)
      .def("claimed", &Scene::claimed, "block"_a, "slot"_a, "at"_a, "causes"_a)
      .def("finished", &Scene::finished, "block"_a, "slot"_a, "at"_a, "causes"_a)
      .def("put_back", &Scene::put_back, "block"_a, "at"_a)
      .def("dropped", &Scene::dropped, "block"_a, "at"_a)
      .def("removed", &Scene::removed, "block"_a)
      .def("slot_failed", &Scene::slot_failed, "slot"_a, "at"_a)
      .def("report_json", &Scene::report_json, "now"_a, "causes"_a = std::vector<std::vector<std::int64_t>>{});
}
