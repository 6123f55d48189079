// The account of jobs and its chains of causes, on events that a test tells by hand.
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>

#include "cmrc/measures/ledger.hpp"
#include "report/values/run_report.hpp"
#include "tests/bindings/bindings.hpp"

namespace {

using report::Time;

Time seconds(double s) { return Time{std::llround(s * 1e12)}; }

/// The ledger with times in seconds and one cause, for tests of the classes of ruling 16.
class LedgerInSeconds {
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

/// The ledger with times in picoseconds, a clock of 1 THz (a cycle is a picosecond), and causes "execute" and "bus".
class LedgerInPicoseconds {
 public:
  explicit LedgerInPicoseconds(std::size_t kept)
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
    cmrc::Ledger::Report ledger = ledger_.tell(
        Time{now}, [&](unsigned slot) { return slot < causes.size() ? causes[slot] : cmrc::CauseTimes{}; });
    report::RunReport run;
    run.tasks = std::move(ledger.tasks);
    run.missed = std::move(ledger.misses);
    run.misses_left_out = ledger.misses_left_out;
    run.audit = std::move(ledger.audit);
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

void bind_ledger(py::module_& test) {
  using namespace py::literals;
  py::module_ m = test.def_submodule("ledger", "The account of jobs, alone.");
  py::class_<LedgerInSeconds>(m, "LedgerInSeconds", "The account of jobs; seconds.")
      .def(py::init<>())
      .def("release", &LedgerInSeconds::release, py::arg("block"), py::arg("kind"), py::arg("released"),
           py::arg("deadline") = py::none())
      .def("skipped", &LedgerInSeconds::skipped)
      .def("claimed", &LedgerInSeconds::claimed)
      .def("finished", &LedgerInSeconds::finished)
      .def("put_back", &LedgerInSeconds::put_back)
      .def("dropped", &LedgerInSeconds::dropped)
      .def("removed", &LedgerInSeconds::removed)
      .def("slot_failed", &LedgerInSeconds::slot_failed)
      .def("violations", &LedgerInSeconds::violations)
      .def("report", &LedgerInSeconds::report);
  py::class_<LedgerInPicoseconds>(m, "LedgerInPicoseconds",
                                  "A ledger whose events a test gives one by one; picoseconds.")
      .def(py::init<std::size_t>(), "kept"_a = 1000)
      .def("release", &LedgerInPicoseconds::release, "block"_a, "kind"_a, "released"_a, "deadline"_a = py::none(),
           "robot"_a = 0)
      .def("skipped", &LedgerInPicoseconds::skipped, "kind"_a, "released"_a, "deadline"_a, "tick"_a, "found"_a)
      .def("refresh", &LedgerInPicoseconds::refresh, "began"_a, "wanted"_a, "held"_a, "freed"_a, "offered"_a)
      .def("slot", &LedgerInPicoseconds::slot, "slot"_a, "state"_a, "at"_a)
      .def("list", &LedgerInPicoseconds::list, "owner"_a, "at"_a)
      .def("bus", &LedgerInPicoseconds::bus, "slot"_a, "a"_a, "start"_a, "end"_a)
      .def("claimed", &LedgerInPicoseconds::claimed, "block"_a, "slot"_a, "at"_a, "causes"_a)
      .def("finished", &LedgerInPicoseconds::finished, "block"_a, "slot"_a, "at"_a, "causes"_a)
      .def("put_back", &LedgerInPicoseconds::put_back, "block"_a, "at"_a)
      .def("dropped", &LedgerInPicoseconds::dropped, "block"_a, "at"_a)
      .def("removed", &LedgerInPicoseconds::removed, "block"_a)
      .def("slot_failed", &LedgerInPicoseconds::slot_failed, "slot"_a, "at"_a)
      .def("report_json", &LedgerInPicoseconds::report_json, "now"_a,
           "causes"_a = std::vector<std::vector<std::int64_t>>{});
}
