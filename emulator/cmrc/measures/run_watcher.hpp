#pragma once
// Reports about DSPs, jobs, refreshes and buses during a run, for drawings: timelines, pages.
//
// The reports are those that the ledger, the timeline of the DSPs and the report's statistics get, nothing more. Each
// comes at most a millisecond after its time; each function gives the order of its calls.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cmrc/measures/missed_job.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/time/time.hpp"
#include "report/values/task_account.hpp"
#include "report/values/why_late.hpp"

namespace pci {
struct Attempt;
}
namespace plant {
class Dock;
}

namespace cmrc {

using report::Time;

/// The state of a DSP for the list: unplugged, failed or booting; asleep until its doorbell; awake without a block;
/// running a block.
enum class SlotState : std::uint8_t { off, asleep, awake, busy };

/// A block that a DSP has claimed.
struct TakenBlock {
  report::JobName job;
  std::size_t block = 0;  ///< its place in the pool
  std::uint32_t generation = 0;
  Time at{};  ///< the program issued the write of 0Fh
};

/// A job that has ended, or is open at the end of the run.
struct EndedJob {
  report::JobName job;
  report::Outcome outcome{};
  bool missed = false;  ///< it counts as a missed deadline
  Time released{};
  std::optional<Time> deadline;
  std::optional<Time> finished;  ///< the program issued the write of FFh
  Time end{};                    ///< end of its account (docs/report.md, Why late)
  bool skipped = false;          ///< a nominal tick for which no block could be released
};

/// The waits of a missed job, and the blocks that were in its way.
struct MissedWaits {
  const MissedJob& job;
  const report::WaitTimes& waits;
  const std::vector<report::BlockingJob>& behind;
};

/// Changes nothing in the run. Every function does nothing unless overridden.
class RunWatcher {
 public:
  virtual ~RunWatcher() = default;

  // A DSP: the calls of one slot come in the order in which they reach the list, which can be a little after their
  // time.
  /// The DSP is off, asleep, or awake: it reports this itself, gets a doorbell, or is given up. Also called without a
  /// change.
  virtual void slot_is(unsigned /*slot*/, SlotState, Time /*at*/) {}
  /// The DSP's program runs, and has reported over the link.
  virtual void booted(unsigned /*slot*/, Time /*at*/) {}
  virtual void took(unsigned /*slot*/, const TakenBlock&) {}
  /// The block of this job that the DSP claimed does not belong to it any more. The DSP may have been reset since, and
  /// run the block of another job. \param cycles of the run by cause (the ledger's); empty: not known
  virtual void left(unsigned /*slot*/, const report::JobName&, report::Run::End, Time /*at*/,
                    const std::vector<std::int64_t>& /*cycles*/) {}
  /// The DSP waited for an access through a window. Called at `to`, before later events of this DSP.
  virtual void held_up(unsigned /*slot*/, machine::Window, Time /*from*/, Time /*to*/) {}
  /// The DSP requested the list's semaphore, which another master has.
  virtual void refused(unsigned /*slot*/, Time /*at*/) {}
  /// The list's semaphore belongs to `owner` (slot + 1, machine::host_owner) from `at` on, or is free (0).
  virtual void list(unsigned /*owner*/, Time /*at*/) {}

  // Jobs
  /// Called when the host has seen the end of a job, or given it up; for open jobs at the end of the run.
  virtual void ended(const EndedJob&) {}
  /// After ended() of the same job.
  virtual void missed(const MissedWaits&) {}

  /// At the beginning of a watch: this process runs, as the event `process` names it (docs/trace.md).
  virtual void process_runs(unsigned /*number*/, unsigned /*agv*/) {}
  /// The host's refresh ended at `end`, with this number of blocks in the list. Refreshes end in the order of their
  /// beginnings; one may begin before the end of the one before.
  virtual void refreshed(const RefreshTimes&, Time /*end*/, std::size_t /*blocks*/) {}
  /// At the end of the run: a refresh is under way.
  virtual void refreshing(const RefreshTimes&, Time /*now*/) {}
  /// A master was on a bus, from attempt.frame to attempt.last of the bus's clock; for each bus in the order of time.
  virtual void on_bus(machine::BusId, const pci::Attempt&, const machine::Clock&) {}
  /// At the end of the run: a master is on a bus, and has been so far.
  virtual void still_on_bus(machine::BusId, const pci::Attempt&, const machine::Clock&) {}
  /// The drives have latched; the dock has advanced to `now`.
  virtual void latched(const plant::Dock&, Time /*now*/) {}

  /// Called while an exception of one of these functions is handled; no call follows. Unless overridden, the exception
  /// ends the run.
  virtual void failed() { throw; }
};

}  // namespace cmrc
