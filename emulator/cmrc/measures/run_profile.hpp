#pragma once
// The cycles of the DSPs in a run: by task kind, and by instruction within each.
//
// A DSP works on a job from the instruction that writes 0Fh into the block's flag up to, not including, the instruction
// that writes FFh: the same two instants between which the ledger counts a job's cycles. The cycles between jobs are
// the executive's.
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "c40/observers/profile.hpp"
#include "cmrc/measures/ledger.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/system/machine.hpp"
#include "report/text/profile_report.hpp"

namespace toolchain {
struct Image;
}

namespace cmrc {

class RunProfile {
 public:
  /// \param machine of the run; must outlive this object; no chip has executed anything yet
  explicit RunProfile(machine::Machine& machine);

  /// The sink gets everything that the DSP does; null removes it.
  void trace(unsigned slot, c40::TraceSink* sink) { slots_.at(slot)->stream.hand_on_to(sink); }

  /// The DSP issues the write that claims a block (0Fh) or ends it (FFh).
  void taken(unsigned slot, Time issued);
  void done(unsigned slot, machine::Offset offset, Time issued);
  /// The write of 0Fh has reached the block of this job.
  void claimed(unsigned slot, Time issued, const std::optional<report::JobName>& job);
  /// What a write of FFh has ended: a job, or a part of one that continues; or nothing.
  struct Result {
    std::optional<report::JobName> job;
    bool part = false;
  };
  void landed(unsigned slot, machine::Offset offset, Time issued, const Result& result);
  /// Ends the DSP's present job.
  void reset(unsigned slot);

  /// Groups in the order of `tasks` (kinds with finished jobs), then "not finished" (jobs that were running at the end,
  /// lost or given up), "executive", "claim", "idle" and "halted". Their sum is the sum of the DSPs' cycles, for each
  /// cause.
  /// \param tasks the run's; \throws std::logic_error if a kind's cycles differ from those of its report
  report::Profile report(const std::vector<report::TaskReport>& tasks, const toolchain::Image& image,
                         const toolchain::Image& rom) const;

 private:
  /// The cycles of a run of a block, and the part of them outside all instructions.
  struct Span {
    c40::ProfileCounts counts;
    c40::Causes outside{};
    Time taken{};
    std::optional<report::JobName> job{};  // once its claim has landed
  };
  /// The finished parts of a job that continues.
  struct Continued {
    report::JobName job;
    std::unique_ptr<Span> parts;
  };
  struct Ended {
    machine::Offset offset;
    Time issued;
    std::unique_ptr<Span> span;
  };
  struct Slot {
    c40::Profile stream;
    std::unique_ptr<Span> job;  // the present job; null: the executive
    c40::Causes at_start{};     // the chip's counters when the job was claimed
    std::deque<Ended> ended{};  // writes of FFh under way
  };
  struct Kind {
    std::uint64_t jobs = 0;
    Span sum;
  };

  std::unique_ptr<Span> end_job(unsigned slot);
  c40::Causes outside_of_job(unsigned slot) const;
  Kind unfinished_now() const;
  std::unique_ptr<Span> fresh();
  void add(Span& to, std::unique_ptr<Span> span);
  void book(Kind& kind, std::unique_ptr<Span> span);

  const machine::Machine& machine_;
  c40::ProfileCounts executive_;
  std::vector<std::unique_ptr<Slot>> slots_;
  std::vector<Kind> kinds_;           // by JobKind
  std::vector<Continued> continued_;  // jobs in parts that are not finished, some of them given up
  Kind unfinished_;
  std::vector<std::unique_ptr<Span>> spare_;
};

}  // namespace cmrc
