#pragma once
// The kinds of jobs, one row each: the report's key, the program in the executive's table, the assumed longest run
// before one is measured, and the period of its heartbeat if it has one.
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "cmrc/tasks/words.hpp"

namespace cmrc {

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

struct KindRow {
  std::string_view name;              ///< key of ruling 29
  Word Words::* program;              ///< its KIND_*; null: it has no program of its own
  double Config::Watchdog::* run_us;  ///< longest run at the start of a run
  double heartbeat_us;  ///< limit between two beats of its program (lib/alive.asm), at nominal clock; 0: no heartbeat
};
/// By JobKind.
const std::array<KindRow, 13>& kind_rows();
/// Their keys.
std::vector<std::string> job_kinds();
/// The job kind of a program (KIND_*).
JobKind job_kind(Word kind, const Words& words);

}  // namespace cmrc
