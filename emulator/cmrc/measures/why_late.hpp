#pragma once
// The chains of causes of missed jobs (report/values/why_late.hpp), from the ledger's record of a job and the timeline
// of its DSPs.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cmrc/measures/missed_job.hpp"
#include "cmrc/measures/timeline.hpp"
#include "cmrc/tasks/block_audit.hpp"
#include "report/values/task_account.hpp"
#include "report/values/why_late.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

/// Collects chains. Usual runs are known only at the end, so the chains are completed when the report is made.
class WhyLate {
 public:
  /// \param kinds names of the job kinds \param causes names of the causes of a run's picoseconds \param kept number of
  /// chains kept one by one
  /// \param own_slots by kind, the slot whose DSP alone may run it
  WhyLate(std::vector<std::string> kinds, std::vector<std::string> causes, std::size_t kept,
          std::vector<std::optional<unsigned>> own_slots);

  /// A job has run from claim to end in this time, by cause: possibly the shortest run of its kind.
  void ran(std::size_t kind, std::int64_t execution, const std::vector<std::int64_t>& causes);
  /// A missed job, with the timeline from its release to its end. If its parts do not add up, the audit reports it.
  /// \param watcher gets its waits; null: none
  void missed(const MissedJob& job, const Timeline& timeline, BlockAudit& audit, RunWatcher* watcher = nullptr);

  /// Chains one by one, in the order of their calls, at most `kept`.
  std::vector<report::MissReport> misses(BlockAudit& audit) const;
  std::uint64_t left_out() const { return left_out_; }
  /// The sum of the chains.
  report::WhyLate summary(std::size_t kind, BlockAudit& audit) const;
  void list_state(state::Visitor& list);

 private:
  struct Chain {
    MissedJob job;
    report::WaitTimes waits{};
    std::vector<report::BlockingJob> behind;
  };
  struct Sums {
    report::WhyLate summary;
    report::WaitTimes waits{};
    std::vector<std::int64_t> execution;
    std::int64_t ran = 0;      // chains with a run at the end
    std::int64_t allowed = 0;  // deadline - release
    std::vector<std::int64_t> behind;
  };

  report::MissReport close(const Chain& chain, BlockAudit& audit) const;
  /// \param execution summed over `ran` runs \param not_run jobs without a run
  std::vector<report::Share> parts(const report::WaitTimes& waits, const std::vector<std::int64_t>& execution,
                                   std::int64_t ran, std::int64_t not_run, const std::optional<report::Usual>& usual,
                                   std::optional<std::int64_t> slack) const;

  std::vector<std::string> kinds_, causes_;
  std::size_t kept_;
  std::vector<std::optional<unsigned>> own_slots_;
  std::vector<std::optional<report::Usual>> usual_;
  std::vector<Chain> chains_;
  std::vector<Sums> sums_;
  std::uint64_t left_out_ = 0;
};

}  // namespace cmrc
