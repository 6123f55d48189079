// Events, statistics and the account of jobs, without a run.
#include <pybind11/stl.h>

#include "python/bindings/interpreter/state.hpp"
#include "report/events/event_log.hpp"
#include "report/values/run_report.hpp"
#include "report/values/task_account.hpp"
#include "tests/bindings/bindings.hpp"

namespace {

using report::Time;

report::Event make_event(std::int64_t time_ps, unsigned component, unsigned kind,
                         const std::vector<std::uint32_t>& arguments) {
  report::Event event{
      Time(time_ps), static_cast<report::Component>(component), static_cast<report::EventKind>(kind), {}};
  if (arguments.size() > event.arguments.size()) throw py::value_error("an event has at most five arguments");
  std::copy(arguments.begin(), arguments.end(), event.arguments.begin());
  return event;
}

/// Keeps the events that it gets, for tests of the order.
class LineRecorder final : public report::EventSink {
 public:
  void event(const report::Event& event) override { lines.push_back(report::to_text(event)); }
  std::vector<std::string> lines;
};

std::vector<Time> periods_of(const std::vector<std::int64_t>& picoseconds) {
  std::vector<Time> periods;
  for (const std::int64_t period : picoseconds) periods.emplace_back(period);
  return periods;
}

std::string add_job(report::TaskAccount& account, std::size_t kind, const std::string& progress, std::int64_t released,
                    std::optional<std::int64_t> deadline, std::int64_t claimed, std::int64_t finished, std::int64_t now,
                    std::optional<std::int64_t> tick, std::vector<std::int64_t> causes) {
  static const std::vector<std::string> names = {"finished", "running", "waiting", "lost", "dropped"};
  const auto found = std::find(names.begin(), names.end(), progress);
  if (found == names.end()) throw py::value_error("progress is finished, running, waiting, lost or dropped");
  report::Job job;
  job.kind = kind;
  job.progress = static_cast<report::Progress>(found - names.begin());
  job.released = Time(released);
  if (deadline) job.deadline = Time(*deadline);
  job.claimed = Time(claimed);
  job.finished = Time(finished);
  job.tick = tick;
  job.causes = std::move(causes);
  return name(account.add(job, Time(now)));
}

}  // namespace

void bind_report(py::module_& test) {
  using namespace py::literals;
  py::module_ room = test.def_submodule("report", "Events, statistics and the report of a run, each alone.");

  room.def(
      "event_text",
      [](std::int64_t time, unsigned component, unsigned kind, const std::vector<std::uint32_t>& arguments) {
        return report::to_text(make_event(time, component, kind, arguments));
      },
      "time_ps"_a, "component"_a, "kind"_a, "arguments"_a, "One line of the event trace.");

  // NOLINTNEXTLINE(bugprone-unused-raii): the constructor registers the class
  py::class_<report::EventSink>(room, "EventSink", "Receives events in their final order.");
  py::class_<LineRecorder, report::EventSink>(room, "Recorder", "Hears a log's events in their final order.")
      .def(py::init<>())
      .def_readonly("lines", &LineRecorder::lines);

  py::class_<report::EventLog> event_log(room, "EventLog", "Orders and hashes events.");
  bind_state<report::EventLog>(event_log);
  event_log.def(py::init<>())
      .def(
          "add",
          [](report::EventLog& log, std::int64_t time, unsigned component, unsigned kind,
             const std::vector<std::uint32_t>& arguments) { log.add(make_event(time, component, kind, arguments)); },
          "time_ps"_a, "component"_a, "kind"_a, "arguments"_a = std::vector<std::uint32_t>{})
      .def(
          "settle", [](report::EventLog& log, std::int64_t time) { log.settle(Time(time)); }, "time_ps"_a)
      .def("flush", &report::EventLog::flush)
      .def("listen", &report::EventLog::listen, "sink"_a, py::keep_alive<1, 2>())
      .def("hash", &report::EventLog::hash)
      .def_property_readonly("count", &report::EventLog::count);

  room.def(
      "time_hashing",
      [](std::size_t events) {
        report::EventLog log;
        for (std::size_t i = 0; i < events; ++i) {
          const auto low = static_cast<std::uint32_t>(i);
          log.add({Time(static_cast<std::int64_t>(i ^ 3)),
                   static_cast<report::Component>(low & 31),
                   report::EventKind::claim,
                   {low, 1, 2, 3, 4}});
          log.settle(Time(static_cast<std::int64_t>(i & ~std::size_t{3})));
        }
        log.flush();
        return log.hash();
      },
      "events"_a, py::call_guard<py::gil_scoped_release>(),
      "Hashes that many events, slightly out of order (a benchmark).");

  py::class_<report::Summary>(room, "Summary", "Statistics of integer samples.")
      .def_readonly("count", &report::Summary::count)
      .def_readonly("best", &report::Summary::best)
      .def_readonly("mean", &report::Summary::mean)
      .def_readonly("p50", &report::Summary::p50)
      .def_readonly("p99", &report::Summary::p99)
      .def_readonly("p99_9", &report::Summary::p99_9)
      .def_readonly("worst", &report::Summary::worst)
      .def_readonly("exact_percentiles", &report::Summary::exact_percentiles)
      .def_readonly("log2_histogram", &report::Summary::histogram);
  room.def(
      "summary",
      [](const std::vector<std::int64_t>& samples, std::size_t samples_max) {
        report::Distribution distribution(samples_max);
        for (const std::int64_t sample : samples) distribution.add(sample);
        return distribution.summary();
      },
      "samples"_a, "samples_max"_a = report::Distribution::usual_samples_max);

  py::class_<report::TaskAccount> account(room, "TaskAccount", "Books jobs under one outcome each.");
  bind_state<report::TaskAccount>(account);
  account
      .def(py::init([](std::vector<std::string> kinds, std::vector<std::string> causes,
                       const std::vector<std::int64_t>& periods, std::size_t samples_max) {
             return report::TaskAccount(std::move(kinds), std::move(causes), periods_of(periods), samples_max);
           }),
           "kinds"_a, "causes"_a, "periods_ps"_a, "samples_max"_a = report::Distribution::usual_samples_max)
      .def("add", &add_job, "kind"_a, "progress"_a, py::kw_only(), "released"_a, "deadline"_a = py::none(),
           "claimed"_a = 0, "finished"_a = 0, "now"_a = 0, "tick"_a = py::none(),
           "causes"_a = std::vector<std::int64_t>{});

  py::class_<report::RunReport>(room, "RunReport",
                                "What a run says of itself; docs/report.md is the schema of its JSON.")
      .def(py::init<>())
      .def(
          "set_tasks", [](report::RunReport& run, const report::TaskAccount& account) { run.tasks = account.report(); },
          "account"_a)
      .def("to_json", [](const report::RunReport& run) { return to_json(run); })
      .def("to_text", [](const report::RunReport& run) { return to_text(run); })
      .def_readonly("hash", &report::RunReport::hash);
}
