#pragma once
// The ledger's record of a missed job, from which its chain of causes is made.
#include <cstdint>
#include <optional>
#include <vector>

#include "report/values/task_account.hpp"
#include "report/values/why_late.hpp"

namespace cmrc {

using report::Time;

/// The times of one refresh of the host, until it has released the list.
struct RefreshTimes {
  Time began{}, wanted = Time::max(), held = Time::max(), free = Time::max();  ///< never: not yet
};

/// One wait in the list and the run that followed it, if any. A recomputed job, and a job in parts, has several.
struct Try {
  Time waits_from{};
  std::optional<Time> first_refresh;   ///< the first refresh that began while it waited
  std::optional<RefreshTimes> put_up;  ///< the refresh after which it could be claimed
  std::optional<report::Run> run;
};

/// Everything known of a missed job.
struct MissedJob {
  report::JobName name;
  report::Outcome outcome{};
  Time released{};
  std::optional<Time> deadline;
  Time end{};
  std::vector<Try> tries;
  std::vector<std::int64_t>
      execution;                 ///< ps of its last run, of all parts, by cause; empty if it has no run that counts
  std::optional<Time> given_up;  ///< after this time no run could follow
  std::optional<std::int64_t> previous;
  report::Wait dropped_by = report::Wait::host_late;  ///< of a dropped tick
};

}  // namespace cmrc
