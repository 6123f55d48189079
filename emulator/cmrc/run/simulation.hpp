#pragma once
// A run: machine, dock and host made from a configuration, run in virtual time, and the report of it.
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "cmrc/measures/measures.hpp"
#include "cmrc/measures/run_watcher.hpp"
#include "cmrc/programs/dsp_image.hpp"
#include "cmrc/run/snapshot.hpp"
#include "report/event_log.hpp"
#include "report/profile_report.hpp"
#include "report/run_report.hpp"

namespace c40 {
class TraceSink;
}
namespace machine {
class Machine;
}
namespace plant {
class Dock;
}
namespace toolchain {
struct Image;
}

namespace state {
class Visitor;
}

namespace cmrc {

/// How far a run is.
struct Progress {
  report::Time simulated{};
  report::Time duration{};
  unsigned containers_delivered = 0;
  std::uint64_t misses = 0;  ///< jobs that have ended late, been dropped or lost so far
};

/// One run. Errors of the configuration come from the constructor, the run itself ends with a stop reason.
///
/// Wall-clock time, tracing and progress change nothing in the run nor in its hash.
class Simulation {
 public:
  /// \throws ConfigError
  /// \throws toolchain::AssemblyError
  /// \throws std::invalid_argument of an image without the shared words
  explicit Simulation(const Config& config);
  /// The same, recorded in `course`; or measured against an ideal run that is there already.
  Simulation(const Config& config, std::shared_ptr<Course> course);
  Simulation(const Config& config, std::shared_ptr<const Reference> reference);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// Hears every event in its final order; must outlive the run. Before run().
  void listen(report::EventSink& sink);
  /// Hears every event as it becomes known, in no order, and not later than a millisecond after its time; null: nobody.
  void tap(report::EventSink* sink);
  /// Hears of its DSPs, jobs, refreshes and buses from now on, and at first how they stand; must outlive the run.
  /// Before run(), after restore().
  void watch(RunWatcher& watcher);
  /// Tells the watchers of the jobs that stand open, as report_so_far() books them. Once, when the run does not go on.
  void close_watch();
  /// Names of a job's causes, in the order in which a watcher hears of its cycles.
  static std::vector<std::string> causes();
  /// Hears the instructions of one DSP; must outlive the run. Before run().
  void trace(unsigned slot, c40::TraceSink& sink);
  /// Counts from now on where the DSPs' cycles go. Before run(); it slows the run down and changes nothing else.
  void profile();
  /// \throws std::logic_error without profile(), and if the profile and report() contradict each other
  report::Profile profile_report() const;

  /// A further event, not before the present time. \throws ConfigError also when it contradicts those that are still
  /// to come
  void at(const TimedEvent& event);

  static constexpr report::Time usual_slice = std::chrono::milliseconds{20};
  /// Runs to the end of the configured duration. `on_progress` is called about every `slice` of simulated time; false
  /// stops the run cleanly (stop reason: interrupted), and so does io::stop_asked(). May be called again: it goes on
  /// where it stopped. With `until` it stops there, and the run is not over.
  void run(const std::function<bool(const Progress&)>& on_progress = {}, report::Time slice = usual_slice,
           report::Time until = report::Time::max());
  /// Runs until `time`, or the end of the duration if that is earlier; less far when io::stop_asked().
  void run_until(report::Time time);
  bool ended() const;
  /// As far as the run has come.
  report::Time time() const;
  /// Jobs that have ended late, been dropped or lost so far.
  std::uint64_t misses() const;

  /// \throws std::runtime_error when the ideal run has died; io::Stopped while it waits for the ideal run: it may be
  /// called again
  report::RunReport report() const;
  /// The same of what has run when io::stop_asked(): the ideal run counts as far as it has come, the stop reason is
  /// interrupted. For a run that does not go on: listeners have heard every event then, also those that others may
  /// still have come before. run() then throws std::logic_error, as do run_until() and snapshot(), until restore().
  report::RunReport report_so_far();
  bool interrupted() const;
  /// The ideal run that this run is measured against; null while the run is not over, and where there is none.
  std::shared_ptr<const Reference> reference() const;
  /// Where this run's crane, load and vehicles were.
  const Course& course() const;
  /// The accounts of the jobs so far, by kind.
  std::vector<report::TaskReport> tasks() const;
  /// The jobs so far, by kind and robot.
  JobsByRobot jobs() const;
  /// What `--strict` asks: completed, no deadline missed, no error that had to be handled.
  bool strictly_good() const;
  /// The run as it is now. What listeners have not heard by then (the events of the last millisecond) they hear before.
  /// \throws std::logic_error with profile(): what was counted would be lost
  Snapshot snapshot();
  /// The run is as it was at the snapshot. Listeners and traces stay; they hear what comes after it.
  /// \throws SnapshotError when it is another configuration's or another version's; then nothing has changed
  void restore(const Snapshot& snapshot);
  /// The first value of the state in which it differs from another run, "machine.dsps.0.chip.pc: ..."; none: they are
  /// alike.
  std::optional<std::string> difference(const Simulation& other) const;
  /// What lasts of it, for tests that look at each value, and for who goes back and forth in one process. After loading
  /// what was measured is measured anew.
  void list_state(state::Visitor& list);
  /// Another run with the same past.
  std::unique_ptr<Simulation> fork();
  /// The run of `whole`, which has this run's configuration and further events from now on: it ends as one that was run
  /// from the start. `reference` may be null. \throws ConfigError
  std::unique_ptr<Simulation> fork_into(const Config& whole, std::shared_ptr<const Reference> reference);

  /// Exit status of rulings 24 and 36: 0, or 1.
  int exit_status() const;

  const Config& config() const;
  const toolchain::Image& image() const;
  machine::Machine& machine();
  const machine::Machine& machine() const;
  const plant::Dock& dock() const;

  class Parts;

 private:
  std::unique_ptr<Parts> parts_;
};

}  // namespace cmrc
