#pragma once
// Why deadlines were missed. Each missed job has a chain of causes in whole picoseconds, whose parts add up to the
// lateness exactly. The chains are also summed per kind (docs/report.md, Why late; rulings 16 to 18).
//
//     lateness = end - deadline = sum of the waits + (execution - usual) - slack,   slack = deadline - release - usual
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "report/events/event.hpp"
#include "report/values/statistics.hpp"

namespace report {

/// The name of a job: its kind (index into the account's kinds), its robot (0 crane, n AGV n - 1), and its number
/// within its kind: the nominal tick of a periodic job, else counted from 0.
struct JobName {
  std::size_t kind = 0;
  std::uint32_t robot = 0;
  std::int64_t number = 0;
  bool operator==(const JobName&) const = default;
};

/// What a job can wait for before it runs. Each instant of its waiting has exactly one of these.
enum class Wait : std::uint8_t {
  host_late,     ///< the host's refresh that released it began late: paused, or busy with the refresh before
  not_due,       ///< in the list with J = 0
  host_refresh,  ///< the refresh was running, until it released the list
  host_lock,     ///< the refresh waited for the list
  doorbell,      ///< every free DSP was asleep: the doorbell and the wake-up
  claim,         ///< a DSP was free: the instructions of its claim
  claim_bus_a,   ///< ... its bus accesses
  claim_bus_b,
  lock,          ///< ... while another master held the list
  behind_list,   ///< every DSP ran a block; DSPs claimed blocks with earlier places in the list while this block could
                 ///< have been claimed
  blocked,       ///< every DSP ran a block that was claimed before this one could be (non-preemptive blocking)
  no_dsp,        ///< no DSP was running
  own_dsp_out,   ///< the only DSP that may run it (dsp of [[tasks]]) was not running
  lost_run,      ///< failed runs, from the claim to the failure, or to where the watchdog took the block
  watchdog,      ///< from the failure of its DSP until the host put the block back
  previous_out,  ///< a dropped tick: the block of an earlier tick was not done
  stopped_by_error,  ///< a dropped tick: an error had stopped the servo, or was not decided yet
  left_out,          ///< a dropped tick: an experiment left it out (scheduling.servo_loss_share, servo_served_every)
};
inline constexpr std::size_t wait_count = 18;
std::string name(Wait wait);
using WaitTimes = std::array<std::int64_t, wait_count>;  ///< ps

/// Why a tick was dropped, as the terminal says it; in a report it is "dropped_" and the cause's name.
struct DropCause {
  Wait wait;
  std::string_view text;
};
inline constexpr DropCause drop_causes[] = {
    {Wait::previous_out, "the previous block was not done when the next was due"},
    {Wait::host_late, "the host skipped the refresh of its tick"},
    {Wait::stopped_by_error, "an error had stopped the servo, or was not decided yet"},
    {Wait::left_out, "left out by the experiment (scheduling.servo_*)"},
};

/// A block that was in the way.
struct BlockingJob {
  JobName job;
  unsigned slot = 0;
  Time claimed{};
  Time from{}, to{};       ///< from when to when it was in the way
  std::int64_t share = 0;  ///< ps: at each instant all blocks in the way have equal parts
  bool overtook = false;   ///< a DSP claimed it while the waiting block could have been claimed
};

/// One run of the job on a DSP.
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
  Time end{};  ///< end of the run that finished; for a dropped tick its deadline; the time when it was given up; or the
               ///< end of the simulation
  std::optional<std::int64_t> lateness;  ///< end - deadline
  std::optional<std::int64_t> usual;     ///< shortest run of its kind; none: no job of the kind has finished
  std::optional<Time> unavoidable;  ///< first instant at which now + the shortest remaining time is past the deadline
  std::vector<Share> parts;         ///< only parts that are not 0; their sum is the lateness
  std::vector<BlockingJob> behind;
  std::vector<Run> runs;
  std::optional<std::int64_t> previous;  ///< dropped tick: number of the job that was not done
};

/// Chains of a kind, summed; dropped ticks are only counted.
struct WhyLate {
  std::uint64_t chains = 0;         ///< misses over which parts and lateness are summed
  std::uint64_t with_deadline = 0;  ///< those of them with a deadline
  std::int64_t lateness = 0;
  std::vector<Share> parts;
  std::vector<Share> behind;                        ///< ps by kind of the blocks in the way
  std::array<std::uint64_t, wait_count> dropped{};  ///< dropped ticks by cause
  std::optional<std::int64_t> usual;
};

}  // namespace report
