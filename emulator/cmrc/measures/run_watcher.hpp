#pragma once
// What a run tells of its DSPs, jobs, refreshes and buses while it goes on, for whoever draws them: timelines, pages.
//
// It is what the ledger, the timeline of the DSPs and the report's statistics hear, no more. Nothing is told later than
// a millisecond after its time; each function says in which order its calls come.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cmrc/measures/missed_job.hpp"
#include "machine/machine.hpp"
#include "report/task_account.hpp"
#include "report/why_late.hpp"

namespace pci {
struct Attempt;
}
namespace plant {
class Dock;
}

namespace cmrc {

using report::Time;

/// What a DSP is to the list: gone, broken or booting; asleep until it is rung; awake without a block; running one.
enum class SlotState : std::uint8_t { off, asleep, awake, busy };

/// A block that a DSP has taken.
struct TakenBlock {
  report::JobName job;
  std::size_t block = 0;  ///< its place in the pool
  std::uint32_t generation = 0;
  Time at{};  ///< the program issued the write of 0Fh
};

/// A job that is over, or stands open at the end of the run.
struct EndedJob {
  report::JobName job;
  report::Outcome outcome{};
  bool missed = false;  ///< it counts as a missed deadline
  Time released{};
  std::optional<Time> deadline;
  std::optional<Time> finished;  ///< the program issued the write of FFh
  Time end{};                    ///< of its account (docs/report.md, Why late)
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

  // A DSP: the calls of one slot come in the order in which they reach the list, which can be a little behind their
  // time.
  /// Gone, asleep, or awake: it says so itself, is rung, or is given up. Also where nothing changes.
  virtual void slot_is(unsigned /*slot*/, SlotState, Time /*at*/) {}
  /// Its program runs, and has said so over the link.
  virtual void booted(unsigned /*slot*/, Time /*at*/) {}
  virtual void took(unsigned /*slot*/, const TakenBlock&) {}
  /// The block that it took is no longer its own. \param cycles of the run by cause (the ledger's); empty: not known
  virtual void left(unsigned /*slot*/, report::Run::End, Time /*at*/, const std::vector<std::int64_t>& /*cycles*/) {}
  /// An access through a window has held it up. Told at `to`, before what happens later on this DSP.
  virtual void held_up(unsigned /*slot*/, machine::Window, Time /*from*/, Time /*to*/) {}
  /// It asked for the list's semaphore, which another holds.
  virtual void refused(unsigned /*slot*/, Time /*at*/) {}
  /// The list's semaphore belongs to `owner` (slot + 1, machine::host_owner) from `at` on, or to nobody (0).
  virtual void list(unsigned /*owner*/, Time /*at*/) {}

  // Jobs
  virtual void released(const report::JobName&, Time /*released*/, std::optional<Time> /*deadline*/) {}
  /// When the host has seen the end of a job, or given it up; at the end of the run for those that are open.
  virtual void ended(const EndedJob&) {}
  /// After ended() of the same job.
  virtual void missed(const MissedWaits&) {}

  /// The host's refresh is over at `end`, with so many blocks in the list.
  virtual void refreshed(const RefreshTimes&, Time /*end*/, std::size_t /*blocks*/) {}
  /// A master was on a bus, from attempt.frame to attempt.last of the bus's clock; of each bus in the order of time.
  virtual void on_bus(machine::BusId, const pci::Attempt&, const machine::Clock&) {}
  /// The drives have latched; the dock stands at `now`.
  virtual void latched(const plant::Dock&, Time /*now*/) {}
};

}  // namespace cmrc
