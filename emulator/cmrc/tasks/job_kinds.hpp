#pragma once
// The kinds of jobs, one row each. Report, page, timelines, account, image symbols, equation (7), the steps of
// processes and the kinds that users' tasks may not take follow from the rows.
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cmrc {

using Word = std::uint32_t;
struct Task;
struct Words;

/// In the order of ruling 29.
enum class JobKind : std::uint8_t {
  pid,
  torque_compensation,
  trajectory_crane,
  trajectory_agv,
  inverse_crane,
  inverse_agv,
  obstacle_avoidance,
  identify,
  grab_path,
  home_crane,
  home_agv,
  error,
  recompute,
  user  ///< the first of the users' tasks
};

/// The robot class y of table 1 of the paper.
namespace robot_class {
inline constexpr std::uint32_t none = 0, crane = 1, agv = 2;
}  // namespace robot_class

/// The importance of a kind in equation (7) if it does not depend on time, in both readings of the equation.
struct FixedImportance {
  std::uint32_t restored, as_printed;
};
inline constexpr FixedImportance by_time{0, 0};  ///< importance.cpp has a formula for the kind

/// The processes that may have a kind as a step, `task NAME` (docs/processes.md).
enum class StepOf : std::uint8_t { none, crane, agv, both };

/// The key of the configuration that gives the longest run at the start of a run: watchdog.NAME_run_us.
enum class LongestRun : std::uint8_t { servo, planning, long_run };

struct KindRow {
  JobKind kind;
  std::string_view name;    ///< key of ruling 29
  std::string_view symbol;  ///< its number TB_KIND in the DSP programs (task_block.inc); empty: no program of its own
  std::uint32_t x, y;       ///< kind and robot class of table 1 of the paper
  FixedImportance importance;
  StepOf step;
  LongestRun run;
  double heartbeat_us;  ///< limit between two beats of its program (lib/alive.asm), at nominal clock; 0: no heartbeat
};

// tests/kernels/test_heartbeat.py counts the beats; the values leave room for delays by the bus.
inline constexpr auto kind_rows = [] {
  using K = JobKind;
  using S = StepOf;
  using R = LongestRun;
  constexpr std::uint32_t none = robot_class::none, crane = robot_class::crane, agv = robot_class::agv;
  return std::to_array<KindRow>({
      {K::pid, "pid", "KIND_PID", 8, crane, by_time, S::none, R::servo, 0},
      {K::torque_compensation, "torque_compensation", "KIND_TORQUE", 7, crane, by_time, S::none, R::servo, 0},
      {K::trajectory_crane, "trajectory_planning.crane", "KIND_TRAJECTORY_CRANE", 5, crane, by_time, S::none,
       R::planning, 0},
      {K::trajectory_agv, "trajectory_planning.agv", "KIND_TRAJECTORY_AGV", 5, agv, by_time, S::none, R::planning, 0},
      {K::inverse_crane, "inverse_kinematics.crane", "KIND_INVERSE_CRANE", 6, crane, by_time, S::none, R::planning, 0},
      {K::inverse_agv, "inverse_kinematics.agv", "KIND_INVERSE_AGV", 6, agv, by_time, S::none, R::planning, 0},
      {K::obstacle_avoidance,
       "obstacle_avoidance",
       "KIND_AVOIDANCE",
       21,
       agv,
       {0xFFFB, 0xFFFC},
       S::none,
       R::long_run,
       750},
      {K::identify, "identify", "KIND_IDENTIFY", 11, none, {0xFDFF, 0xFDFF}, S::both, R::long_run, 750},
      {K::grab_path, "grab_path", "KIND_GRAB_PATH", 12, none, {0xFBFF, 0xFBFF}, S::both, R::long_run, 750},
      {K::home_crane, "home.crane", "KIND_HOME_CRANE", 13, crane, {0xF7FF, 0xF7FF}, S::crane, R::long_run, 750},
      {K::home_agv, "home.agv", "KIND_HOME_AGV", 22, agv, {0xEFFF, 0xEFFF}, S::agv, R::long_run, 0},
      {K::error, "error", "KIND_ERROR", 1, none, {0xFFFE, 0xFFFE}, S::none, R::long_run, 0},
      {K::recompute, "recompute", "", 2, none, {0xFFFD, 0xFFFC}, S::none, R::long_run, 0},
  });
}();

constexpr const KindRow& row_of(JobKind kind) { return kind_rows[static_cast<std::size_t>(kind)]; }
/// The keys of the rows.
std::vector<std::string> job_kinds();
/// The job kind of a program (KIND_*).
JobKind job_kind(Word kind, const Words& words);
/// A task of a kind for a robot (0 crane, n AGV n - 1): x, y and program from its row; the area of the AGV if the kind
/// is an AGV's, else of the crane.
Task task_of(JobKind kind, const Words& words, std::uint32_t robot = 0);

}  // namespace cmrc
