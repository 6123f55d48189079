#pragma once
// Why deadlines were missed: of each missed job a chain of causes in whole picoseconds whose parts add up to the
// lateness exactly, and the same summed per kind (docs/report.md, Why late; rulings 16 to 18).
//
//     lateness = end - deadline = sum of the waits + (execution - usual) - slack,   slack = deadline - release - usual
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "report/event.hpp"
#include "report/statistics.hpp"

namespace report {

/// Which job: its kind (index into the account's kinds), its robot (0 crane, n AGV n - 1), and its number among its
/// kind: the nominal tick of a periodic one, else counted from 0.
struct JobName {
  std::size_t kind = 0;
  std::uint32_t robot = 0;
  std::int64_t number = 0;
  bool operator==(const JobName&) const = default;
};

/// What a job can wait for before it runs. Every instant of its waiting belongs to one.
enum class Wait : std::uint8_t {
  host_late,     ///< the host's refresh that put it up began late: paused, or busy with the refresh before
  not_due,       ///< in the list with J = 0
  host_refresh,  ///< the refresh was at work, to the release of the list
  host_lock,     ///< the refresh waited for the list
  doorbell,      ///< every free DSP was asleep: to be rung, and waking up
  claim,         ///< a DSP was free: the instructions of its claim
  claim_bus_a,   ///< ... its bus accesses
  claim_bus_b,
  lock,          ///< ... while somebody else held the list
  behind_list,   ///< every DSP ran a block; one or more were claimed while this one could have been: they stood before
                 ///< it
  blocked,       ///< every DSP ran a block that was claimed before this one could be (non-preemptive blocking)
  no_dsp,        ///< no DSP was there
  own_dsp_out,   ///< the one DSP that may run it (dsp of [[tasks]]) was not there
  lost_run,      ///< runs that came to nothing, from the claim to the failure, or to where the watchdog took the block
  watchdog,      ///< from the failure of its DSP to where the host put the block back
  previous_out,  ///< a dropped tick: the block of an earlier one was still out
};
inline constexpr std::size_t wait_count = 16;
std::string name(Wait wait);
using WaitTimes = std::array<std::int64_t, wait_count>;  ///< ps

/// A block that stood in the way.
struct BlockingJob {
  JobName job;
  unsigned slot = 0;
  Time claimed{};
  Time from{}, to{};       ///< in the way from, to
  std::int64_t share = 0;  ///< ps: of each instant every block in the way has an equal part
  bool overtook = false;   ///< it was claimed while the waiting one could have been
};

/// One time that a DSP ran the job.
struct Run {
  unsigned slot = 0;
  Time claimed{};
  Time ended{};
  enum class End : std::uint8_t { done, part, failed, taken_away, running } end = End::running;
};
std::string name(Run::End end);

/// The shortest run of a kind, with its picoseconds by cause.
struct Usual {
  std::int64_t execution = 0;
  std::vector<std::int64_t> causes;
};

/// The chain of one missed job.
struct MissReport {
  JobName job;
  std::string kind;
  std::string outcome;
  Time released{};
  std::optional<Time> deadline;
  Time end{};  ///< of the run that finished; of a dropped tick its deadline; given up; or the end of the simulation
  std::optional<std::int64_t> lateness;  ///< end - deadline
  std::optional<std::int64_t> usual;     ///< shortest run of its kind; none: none has finished
  std::optional<Time> unavoidable;  ///< first instant at which now + the shortest remaining time is past the deadline
  std::vector<Share> parts;         ///< without those that are 0; their sum is the lateness
  std::vector<BlockingJob> behind;
  std::vector<Run> runs;
  std::optional<std::int64_t> previous;  ///< dropped tick: number of the job that was still out
};

/// Chains of a kind, summed; dropped ticks are only counted.
struct WhyLate {
  std::uint64_t chains = 0;         ///< misses that parts and lateness sum over
  std::uint64_t with_deadline = 0;  ///< of them
  std::int64_t lateness = 0;
  std::vector<Share> parts;
  std::vector<Share> behind;  ///< ps by kind of the blocks in the way
  std::uint64_t dropped_previous_out = 0, dropped_host_late = 0;
  std::optional<std::int64_t> usual;
};

}  // namespace report
