#pragma once
// A run: machine, dock and host are made from a configuration and run in virtual time; then the report is made.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cmrc/measures/measures.hpp"
#include "cmrc/measures/run_watcher.hpp"
#include "cmrc/programs/dsp_image.hpp"
#include "cmrc/run/snapshot.hpp"
#include "report/events/event_log.hpp"
#include "report/text/profile_report.hpp"
#include "report/values/run_report.hpp"

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

struct TimedEvent;

/// The progress of a run.
struct Progress {
  report::Time simulated{};
  report::Time duration{};
  unsigned containers_delivered = 0;
  std::uint64_t misses = 0;  ///< jobs that have ended late, been dropped or lost so far
};

/// One run. Errors of the configuration come from the constructor; the run itself ends with a stop reason.
///
/// Wall-clock time, tracing and progress change neither the run nor its hash.
class Simulation {
 public:
  /// \throws ConfigError
  /// \throws toolchain::AssemblyError
  /// \throws std::invalid_argument for an image without the shared words
  explicit Simulation(const Config& config);
  /// The same, recorded in `course`, which is then all that is recorded but for jobs; or measured against an existing
  /// ideal run.
  Simulation(const Config& config, std::shared_ptr<Course> course);
  Simulation(const Config& config, std::shared_ptr<const Reference> reference);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// The sink gets every event in its final order; it must outlive the run. To be called before run().
  void listen(report::EventSink& sink);
  /// The sink gets every event when it becomes known, in no order, at most a millisecond after its time; null: none.
  void tap(report::EventSink* sink);
  /// The watcher gets reports about DSPs, jobs, refreshes and buses from now on, and first their present state; it must
  /// outlive the run. To be called before run(), and after restore().
  void watch(RunWatcher& watcher);
  /// Reports to one watcher what is under way: the open jobs as report_so_far() counts them, refreshes, attempts on
  /// buses. To be called once for each watcher, if the run does not continue.
  void close_watch(RunWatcher& watcher);
  /// Names of a job's causes, in the order of a watcher's cycles.
  static std::vector<std::string> causes();
  /// The sink gets the instructions of one DSP; it must outlive the run. To be called before run().
  void trace(unsigned slot, c40::TraceSink& sink);
  /// Counts the DSPs' cycles by place from now on. To be called before run(); slows the run down and changes nothing
  /// else.
  void profile();
  /// \throws std::logic_error without profile(), and if the profile and report() contradict each other
  report::Profile profile_report() const;

  /// Adds an event, not before the present time. \throws ConfigError also if it contradicts future events
  void at(const TimedEvent& event);

  static constexpr report::Time usual_slice = std::chrono::milliseconds{20};
  /// Runs to the end of the configured duration. `on_progress` is called about every `slice` of simulated time; false
  /// stops the run (stop reason: interrupted), and so does io::stop_asked(). May be called again: the run continues
  /// where it stopped. With `until` it stops there, and the run is not finished.
  void run(const std::function<bool(const Progress&)>& on_progress = {}, report::Time slice = usual_slice,
           report::Time until = report::Time::max());
  /// Runs until `time`, or until the end of the duration if that is earlier; less far after io::stop_asked().
  void run_until(report::Time time);
  bool ended() const;
  /// The present time of the run.
  report::Time time() const;
  /// Jobs that have ended late, been dropped or lost so far.
  std::uint64_t misses() const;

  /// \throws std::runtime_error if the ideal run has died; io::Stopped while it waits for the ideal run: it may then be
  /// called again
  report::RunReport report() const;
  /// The report of what has run, after io::stop_asked(): the ideal run counts as far as it has come, and the stop
  /// reason is interrupted. Only for a run that does not continue: listeners have then got every event, although
  /// earlier ones could still have come. Afterwards run(), run_until() and snapshot() throw std::logic_error, until
  /// restore().
  report::RunReport report_so_far();
  bool interrupted() const;
  /// The ideal run against which this run is measured; null until the run is finished, and if there is none.
  std::shared_ptr<const Reference> reference() const;
  /// The places of this run's crane, load and vehicles.
  const Course& course() const;
  /// The accounts of the jobs so far, by kind.
  std::vector<report::TaskReport> tasks() const;
  /// The jobs so far, by kind and robot.
  JobsByRobot jobs() const;
  /// The condition of `--strict`: completed, a job finished, no deadline missed, no error that had to be handled.
  bool strictly_good() const;
  /// The present state of the run. Listeners first get the events that they do not have yet (those of the last
  /// millisecond). \throws std::logic_error with profile(): its counts would be lost
  Snapshot snapshot();
  /// Sets the run to the state of the snapshot. Listeners and traces stay; they get what comes after it.
  /// \throws SnapshotError for a snapshot of another configuration or version; then nothing has changed
  void restore(const Snapshot& snapshot);
  /// The first value of the state that differs from another run, "machine.dsps.0.chip.pc: ..."; none if the states are
  /// equal.
  std::optional<std::string> difference(const Simulation& other) const;
  /// The run's state, for tests of single values, and for callers that go back and forth in one process. After loading,
  /// results are measured again.
  void list_state(state::Visitor& list);
  /// Another run with the same past.
  std::unique_ptr<Simulation> fork();
  /// The run of `whole`, which is this run's configuration with further events from now on: it ends like a run from the
  /// start. `reference` may be null. \throws ConfigError
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
