#pragma once
// A missed job as the ledger knows it: what its chain of causes is made from.
#include <cstdint>
#include <optional>
#include <vector>

#include "report/task_account.hpp"
#include "report/why_late.hpp"

namespace cmrc {

using report::Time;

/// The host's way through one refresh, to the instant at which the list was free again.
struct RefreshTimes {
  Time began{}, wanted{}, held{}, free{};
};

/// One wait in the list and the run that followed it, if any: a recomputed job has several, and one in parts.
struct Try {
  Time waits_from{};
  std::optional<Time> first_refresh;   ///< the first one that began while it waited
  std::optional<RefreshTimes> put_up;  ///< the refresh after which it could be claimed
  std::optional<report::Run> run;
};

/// All that is known of a missed job.
struct MissedJob {
  report::JobName name;
  report::Outcome outcome{};
  Time released{};
  std::optional<Time> deadline;
  Time end{};
  std::vector<Try> tries;
  std::vector<std::int64_t>
      execution;                 ///< ps of its last run, of all parts, by cause; empty when it has none that counts
  std::optional<Time> given_up;  ///< no run could follow from then on
  std::optional<std::int64_t> previous;
};

}  // namespace cmrc
