#pragma once
// Where the DSPs' cycles of a run went: by task kind, and by instruction within each.
//
// A DSP works on a job from the instruction that writes 0Fh into the block's flag up to, not including, the one that
// writes FFh: the same two instants between which the ledger takes a job's cycles. What lies between jobs is the
// executive's.
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "c40/profile.hpp"
#include "cmrc/measures/ledger.hpp"
#include "machine/machine.hpp"
#include "report/profile_report.hpp"

namespace toolchain {
struct Image;
}

namespace cmrc {

class RunProfile {
 public:
  /// \param machine of the run, which must outlive this; no chip has executed anything yet
  explicit RunProfile(machine::Machine& machine);

  /// Null to hear no more; otherwise it hears everything that the DSP does.
  void trace(unsigned slot, c40::TraceSink* sink) { slots_.at(slot)->stream.hand_on_to(sink); }

  /// The DSP issues the write that takes a block (0Fh) or says that it is done (FFh).
  void taken(unsigned slot);
  void done(unsigned slot, machine::Offset offset, Time issued);
  /// What became of a write of FFh: the job that has ended by it, or none.
  void landed(unsigned slot, machine::Offset offset, Time issued, std::optional<JobKind> job);
  /// Whatever the DSP was at is over.
  void reset(unsigned slot);

  /// Groups in the order of `tasks` (those with finished jobs), then "not finished" (jobs that were running at the end,
  /// lost or given up), "executive", "claim", "idle" and "halted". Their sum is the sum of the DSPs' cycles, cause by
  /// cause.
  /// \param tasks the run's; \throws std::logic_error if a kind's cycles are not those that its report has
  report::Profile report(const std::vector<report::TaskReport>& tasks, const toolchain::Image& image,
                         const toolchain::Image& rom) const;

 private:
  /// A job's cycles, and those of them that belong to no instruction.
  struct Span {
    c40::ProfileCounts counts;
    c40::Causes outside{};
  };
  struct Ended {
    machine::Offset offset;
    Time issued;
    std::unique_ptr<Span> span;
  };
  struct Slot {
    c40::Profile stream;
    std::unique_ptr<Span> job;  // what it works on; null: the executive's
    c40::Causes at_start{};     // the chip's, when the job was taken
    std::deque<Ended> ended{};  // writes of FFh on their way
  };
  struct Kind {
    std::uint64_t jobs = 0;
    Span sum;
  };

  std::unique_ptr<Span> end_job(unsigned slot);
  c40::Causes outside_of_job(unsigned slot) const;
  Kind unfinished_now() const;
  std::unique_ptr<Span> fresh();
  void book(Kind& kind, std::unique_ptr<Span> span);

  const machine::Machine& machine_;
  c40::ProfileCounts executive_;
  std::vector<std::unique_ptr<Slot>> slots_;
  std::vector<Kind> kinds_;  // by JobKind
  Kind unfinished_;
  std::vector<std::unique_ptr<Span>> spare_;
};

}  // namespace cmrc
