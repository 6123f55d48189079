// cmrc._core.cmrc.Simulation: one run, used by one thread at a time.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "cmrc/measures/measures.hpp"
#include "cmrc/run/dock_debuggee.hpp"
#include "cmrc/run/simulation.hpp"
#include "cmrc/tasks/job_kinds.hpp"
#include "cmrc/tasks/words.hpp"
#include "machine/system/machine.hpp"
#include "page/html.hpp"
#include "page/recorder.hpp"
#include "plant/dock/dock.hpp"
#include "python/bindings/c40/chip_inspection.hpp"
#include "python/bindings/cmrc/cmrc.hpp"
#include "python/bindings/cmrc/on_progress.hpp"
#include "python/bindings/debug.hpp"
#include "python/bindings/interpreter/ctrl_c.hpp"
#include "python/bindings/interpreter/one_user.hpp"
#include "python/bindings/interpreter/state.hpp"
#include "python/bindings/interpreter/without_gil.hpp"
#include "report/events/event.hpp"
#include "report/events/trace_text.hpp"
#include "toolchain/objects/image.hpp"

report::Time to_time(const char* argument, double seconds) {
  constexpr double most_seconds = 9e6;  // of 64 bits of picoseconds
  if (!(seconds >= 0 && seconds <= most_seconds))
    throw py::value_error(
        fmt::format("{}: {} s is no instant of a run; 0 to {:g} s are", argument, seconds, most_seconds));
  return report::from_seconds(seconds);
}

namespace {

/// Kind of task by the program's number (KIND_*), named as in the report.
py::dict task_names(const cmrc::Simulation& simulation) {
  const cmrc::Words words([&](std::string_view name) { return simulation.image().symbol(name); });
  const std::vector<std::string> kinds = cmrc::job_kinds(simulation.config().tasks);
  py::dict names;
  for (cmrc::Word kind = 0; kind < words.kind_count; ++kind) {
    const auto index = static_cast<std::size_t>(cmrc::job_kind(kind, words));
    if (index < kinds.size()) names[py::int_(kind)] = kinds[index];
  }
  return names;
}

/// Events that are taken a batch at a time.
class EventBatch final : public report::EventSink {
 public:
  void event(const report::Event& event) override { events_.push_back(event); }
  std::vector<report::Event> take() { return std::exchange(events_, {}); }

 private:
  std::vector<report::Event> events_;
};

/// A run as Python holds it: calls from two threads at once are refused, and so is what changes it from inside a
/// callback.
class Run {
 public:
  template <class... Arguments>
  explicit Run(Arguments&&... arguments)
      : simulation_(std::make_unique<cmrc::Simulation>(std::forward<Arguments>(arguments)...)) {}
  explicit Run(std::unique_ptr<cmrc::Simulation> simulation) : simulation_(std::move(simulation)) {}

  cmrc::Simulation& change(const char* call) {
    user_.changes(call);
    return run_;
  }
  const cmrc::Simulation& read(const char* call) const {
    user_.reads(call);
    return run_;
  }
  OneUser& user() { return user_; }
  /// For short calls that change the run, or must not see it between two states.
  template <class Work>
  auto moment(const char* call, Work work) {
    const OneUser::Long use(user_, call, false);
    const WithoutGil released;
    return work(run_);
  }

  /// \param at_end makes what is returned, before another thread may use the run
  py::object run(const py::object& on_progress, double slice_s, const py::object& at_end) {
    const report::Time slice = to_time("slice_s", slice_s);
    if (slice == report::Time{}) throw py::value_error("slice_s: 0 s; a time greater than 0 is expected");
    OnProgress callback(on_progress);
    const OneUser::Long use(user_, "run", false);
    interruptible_without_gil([&] { run_.run(callback.call(), slice); });
    callback.raise();
    return at_end.is_none() ? at_end : at_end();
  }

  /// Runs in slices. Ctrl-C ends the call between two slices; the caller may then call it again.
  void run_until(double time_s) {
    const report::Time time = to_time("time_s", time_s);
    user_.changes("run_until");
    if (time < run_.time())
      throw py::value_error(
          fmt::format("time_s: {:.9g} s has passed, the run is at {:.9g} s; a later instant is expected", time_s,
                      report::seconds(run_.time())));
    const OneUser::Long use(user_, "run_until", false);
    constexpr report::Time slice = std::chrono::milliseconds{20};
    interruptible_without_gil([&] {
      do run_.run_until(std::min(time, run_.time() + slice));
      while (run_.time() < time && !run_.ended() && !io::stop_asked());
    });
  }

  void keep_events() {
    user_.changes("keep_events");
    if (events_) return;
    events_ = std::make_unique<EventBatch>();
    run_.listen(*events_);
  }
  py::bytes take_events() {
    user_.changes("take_events");
    if (!events_) throw std::logic_error("take_events: keep_events comes before the run");
    const std::vector<report::Event> batch = events_->take();
    return {reinterpret_cast<const char*>(batch.data()), batch.size() * sizeof(report::Event)};
  }
  /// Keeps the text of every event from here on.
  void keep_text_of_events() {
    cmrc::Simulation& simulation = change("keep_text_of_events");
    if (text_trace_) return;
    simulation.listen(text_trace_.emplace(events_text_));
  }
  std::optional<std::string> events_text() const {
    read("result");
    return text_trace_ ? std::optional(events_text_.str()) : std::nullopt;
  }
  /// From now on what a page needs is kept.
  void record(std::size_t stretches) {
    user_.changes("record");
    if (recorder_) throw std::runtime_error("record: this run is recorded already");
    if (run_.ended()) throw std::runtime_error("record: the run is over");
    recorder_ = std::make_unique<page::Recorder>(run_, stretches);
  }
  std::string page(const std::string& title) {
    if (!recorder_)
      throw std::runtime_error("page: nothing of this run was recorded; Simulation.record comes before the run");
    user_.changes("page");
    if (!run_.ended()) throw std::runtime_error("page: the run is not over");
    if (recording_.empty()) {
      const OneUser::Long use(user_, "page", true);
      recording_ = interruptible_without_gil([&] { return recorder_->recording(run_.report(), title); });
    }
    return page::html(recording_, title);
  }

  /// For calls that may wait for the ideal run. Other threads and Ctrl-C do not have to wait.
  template <class Work>
  auto waiting(const char* call, Work work) {
    const OneUser::Long use(user_, call, true);
    return interruptible_without_gil([&] { return work(static_cast<const cmrc::Simulation&>(run_)); });
  }

 private:
  std::unique_ptr<EventBatch> events_;  // outlives the run, which writes to it
  std::ostringstream events_text_;      // these two outlive the run, which writes to them
  std::optional<report::EventTextTrace> text_trace_;
  std::unique_ptr<cmrc::Simulation> simulation_;
  cmrc::Simulation& run_ = *simulation_;
  OneUser user_{"Simulation"};
  std::unique_ptr<page::Recorder> recorder_;
  std::string recording_;  // once it is made
};

/// A DSP of a run.
struct DspOf {
  std::shared_ptr<Run> run;
  unsigned slot;
};

/// Its chip, for reading and for changing.
struct ChipOfDsp {
  const c40::Chip& operator()(const DspOf& d) const { return d.run->read("dsp").machine().chip(d.slot); }
  c40::Chip& operator()(DspOf& d) const { return d.run->change("dsp").machine().chip(d.slot); }
  void poke(DspOf& d, c40::Address address, c40::Word value) const { (*this)(d).poke(address, value); }
  void changed(DspOf& d) const { d.run->change("dsp").machine().look_again(); }
};

void bind_dsp(py::module_& m) {
  const auto machine = [](const DspOf& d) -> const machine::Machine& { return d.run->read("dsp").machine(); };
  py::class_<DspOf> dsp(m, "Dsp", "One DSP of a run.");
  dsp.def_property_readonly("pc", [machine](const DspOf& d) { return machine(d).chip(d.slot).pc(); })
      .def_property_readonly("plugged", [machine](const DspOf& d) { return machine(d).plugged(d.slot); })
      .def_property_readonly("booted", [machine](const DspOf& d) { return machine(d).booted(d.slot); });
  bind_inspection(dsp, ChipOfDsp());
}

DspOf dsp_of(const std::shared_ptr<Run>& run, std::int64_t slot) {
  const std::int64_t slots = run->read("dsp").machine().slots();
  if (slot < 0 || slot >= slots)
    throw py::index_error(fmt::format("there is no slot {}; the slots are 0 to {}", slot, slots - 1));
  return {run, static_cast<unsigned>(slot)};
}

}  // namespace

void bind_simulation(py::module_& m) {
  using cmrc::Simulation;
  bind_dsp(m);
  bind_run_snapshots(m);
  py::class_<Run, std::shared_ptr<Run>>(m, "Simulation", "One run, used by one thread at a time. Times in seconds.")
      .def(py::init<const cmrc::Config&>(), py::arg("config"), py::call_guard<UsualFloats>())
      .def(py::init<const cmrc::Config&, std::shared_ptr<const cmrc::Reference>>(), py::arg("config"),
           py::arg("reference"), py::call_guard<UsualFloats>())
      .def(
          "reference", [](Run& r) { return r.waiting("reference", [](const Simulation& s) { return s.reference(); }); },
          "The ideal run that this run was measured against; None before the end of the run and without a reference.")
      .def("run", &Run::run, py::arg("on_progress") = py::none(), py::arg("slice_s") = 0.02,
           py::arg("at_end") = py::none(),
           "Runs to the end; on_progress(simulated_s, duration_s) may return False to stop. Returns what at_end() "
           "returns; no other thread may use the run before that. Ctrl-C stops cleanly and raises KeyboardInterrupt.")
      .def("run_until", &Run::run_until, py::arg("time_s"))
      .def("record", &Run::record, py::arg("stretches") = page::stretches_max, "Keeps from now on what a page shows.")
      .def(
          "page", [](Run& r, const std::string& title) { return py::bytes(r.page(title)); }, py::arg("title"),
          "The page of a run that is over, as UTF-8.")
      .def("debug",
           [](const std::shared_ptr<Run>& run) {
             return std::make_unique<PythonDebugger>(run, std::make_unique<cmrc::DockDebuggee>(run->change("debug")),
                                                     false, &run->user());
           })
      .def("snapshot", [](Run& r) { return r.moment("snapshot", [](Simulation& s) { return s.snapshot(); }); })
      .def(
          "restore",
          [](Run& r, const cmrc::Snapshot& snapshot) {
            r.moment("restore", [&](Simulation& s) { s.restore(snapshot); });
          },
          py::arg("snapshot"))
      .def("_state", [](Run& r) { return state_bytes(r.change("_state")); })
      .def(
          "_load_state", [](Run& r, const py::bytes& bytes) { load_state(r.change("_load_state"), bytes); },
          py::arg("state"))
      .def("_state_leaves", [](Run& r) { return state_leaves(r.change("_state_leaves")); })
      .def(
          "_state_difference",
          [](Run& r, const Run& other) {
            return r.change("_state_difference").difference(other.read("_state_difference"));
          },
          py::arg("other"))
      .def("fork",
           [](Run& r) { return std::make_shared<Run>(r.moment("fork", [](Simulation& s) { return s.fork(); })); })
      .def(
          "fork_into",
          [](Run& r, const cmrc::Config& whole, std::shared_ptr<const cmrc::Reference> reference) {
            return std::make_shared<Run>(
                r.moment("fork_into", [&](Simulation& s) { return s.fork_into(whole, std::move(reference)); }));
          },
          py::arg("config"), py::arg("reference") = py::none(),
          "The run of a configuration that has this run's and further events from now on. Raises ConfigError.")
      .def(
          "difference",
          [](Run& r, const Run& other) {
            return r.moment("difference", [&](Simulation& s) { return s.difference(other.read("difference")); });
          },
          py::arg("other"), "The first value in which the states of two runs differ, as text; None: they are alike.")
      .def(
          "at", [](Run& r, const py::dict& fields) { r.change("at").at(event_of(fields)); }, py::arg("fields"),
          "A timed event: at_s, action and its fields (docs/configuration.md, [[events]]).")
      // A Dsp owns its run; pybind11 3.1's keep_alive<0, 1> crashes when an argument has a wrong type.
      .def("dsp", &dsp_of, py::arg("slot"))
      .def_property_readonly("program", [](const Run& r) { return r.read("program").image(); })
      .def(
          "peek", [](const Run& r, std::uint32_t offset) { return r.read("peek").machine().peek(offset); },
          "A word of shared memory.")
      .def("symbol", [](const Run& r, const std::string& name) { return r.read("symbol").machine().symbol(name); })
      .def_property_readonly("time_s", [](const Run& r) { return report::seconds(r.read("time_s").time()); })
      .def_property_readonly("misses", [](const Run& r) { return r.read("misses").misses(); })
      .def_property_readonly("ended", [](const Run& r) { return r.read("ended").ended(); })
      .def_property_readonly(
          "exit_status",
          [](Run& r) { return r.waiting("exit_status", [](const Simulation& s) { return s.exit_status(); }); })
      .def("report_json",
           [](Run& r) { return r.waiting("result", [](const Simulation& s) { return report::to_json(s.report()); }); })
      .def(
          "report_so_far_json",
          [](Run& r) {
            return report::to_json(r.moment("report_so_far", [](Simulation& s) { return s.report_so_far(); }));
          },
          "The report of a run that does not continue.")
      .def(
          "report_json_and_text",
          [](Run& r) {
            return r.waiting("result", [](const Simulation& s) {
              const report::RunReport report = s.report();
              return std::pair(report::to_json(report), report::to_text(report));
            });
          },
          "The same report as JSON and as text.")
      .def("keep_text_of_events", &Run::keep_text_of_events, "Keeps the event trace; before the run.")
      .def("events_text", &Run::events_text,
           "The event trace (docs/trace.md) of what a report has been asked of; None where it is not kept.")
      .def("tasks_json", [](const Run& r) { return report::tasks_to_json(r.read("tasks").tasks()); })
      .def(
          "profile", [](Run& r) { r.change("profile").profile(); }, "Counts where the DSPs' cycles go; before the run.")
      .def("profile_json",
           [](Run& r) {
             return r.waiting("result", [](const Simulation& s) { return report::to_json(s.profile_report()); });
           })
      .def("profile_text",
           [](Run& r) {
             return r.waiting("result", [](const Simulation& s) { return report::to_text(s.profile_report()); });
           })
      .def("signals",
           [](Run& r) {
             const auto reference = r.waiting("result", [](const Simulation& s) { return s.reference(); });
             return signals_of(r.read("result").dock(), reference);
           })
      .def("task_names", [](const Run& r) { return task_names(r.read("task_names")); })
      .def("keep_events", &Run::keep_events, "From now on events are kept until they are taken; before the run.")
      .def("take_events", &Run::take_events,
           "The events that are in their final order since the last call, 32 bytes each (docs/trace.md, The hash).")
      .def("dock_events", [](const Run& r) {
        py::list all;
        for (const plant::Event& event : r.read("dock_events").dock().events()) {
          all.append(py::make_tuple(report::seconds(event.time), plant::name(event.kind), event.index, event.values[0],
                                    event.values[1]));
        }
        return all;
      });
}
