#pragma once
// Counts every job under exactly one outcome (ruling 16) and makes the statistics of the task kinds.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "report/events/event.hpp"
#include "report/values/run_report.hpp"
#include "report/values/statistics.hpp"

namespace report {

/// The classes of ruling 16.
enum class Outcome : std::uint8_t { on_time, late, unfinished, never_started, lost, dropped };
std::string name(Outcome outcome);

/// How far a job got. The account derives the outcome from this and the deadline.
enum class Progress : std::uint8_t { finished, running, waiting, lost, dropped };

/// A job: one release of a task. A recomputed block is one job, counted once, with its last claim. The parts of a split
/// task are one job too, with the claim of the first part.
struct Job {
  std::size_t kind = 0;  ///< index into the account's kinds
  Progress progress = Progress::finished;
  Time released{};
  std::optional<Time> deadline;  ///< none: the job is on time when it finishes
  Time claimed{};                ///< when finished, running or lost
  Time finished{};               ///< when finished
  Time between{};                ///< time between the parts of the job: from claimed to finished, but not running
  /// Picoseconds by chip cause while the job ran, in the order of the account's causes; empty if not known. Their sum
  /// should be finished - claimed - between.
  std::vector<std::int64_t> causes;
  std::vector<std::int64_t> cycles;  ///< cycles of the chip by cause, as its counters have them; empty if not known
  std::optional<std::int64_t>
      tick;  ///< number of the nominal tick of a periodic kind: jitter is taken between neighbouring ticks
};

/// Whether a job with that outcome counts as a missed deadline at time `now`.
bool missed(const Job& job, Outcome outcome, Time now);

/// Collects jobs in any order; `report` may be called at any time.
class TaskAccount {
 public:
  /// \param kinds   keys of ruling 29 in report order
  /// \param causes  names of the chips' causes
  /// \param periods nominal period of kind i, or zero if it is not periodic
  /// \param samples_max up to this number of samples the percentiles of a summary are exact
  TaskAccount(std::vector<std::string> kinds, std::vector<std::string> causes, const std::vector<Time>& periods,
              std::size_t samples_max = Distribution::usual_samples_max);

  /// Counts a job. `now` is its end, or the end of the run for an unfinished job. \returns its outcome.
  Outcome add(const Job& job, Time now);
  /// Statistics of every kind.
  std::vector<TaskReport> report() const;
  void list_state(state::Visitor& list);

 private:
  struct Kind {
    TaskReport counts;
    Distribution response, waiting, execution, lateness;
    Starts starts;
    std::vector<std::int64_t> causes, cycles;
    std::uint64_t streak = 0;
  };

  std::vector<std::string> causes_;
  std::vector<Kind> kinds_;
};

}  // namespace report
