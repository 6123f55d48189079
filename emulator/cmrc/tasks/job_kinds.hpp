#pragma once
// The kinds of jobs, one row each: the report's key, the program in the executive's table, how long a run is taken to
// last before one is seen, and the period of its heartbeat where it has one.
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
  user  ///< the first of the user's own tasks
};

struct KindRow {
  std::string_view name;              ///< key of ruling 29
  Word Words::* program;              ///< its KIND_*; null: none of its own
  double Config::Watchdog::* run_us;  ///< longest run at the start
  double heartbeat_us;  ///< at most between two beats of its program (lib/alive.asm), at nominal clock; 0: it has none
};
/// By JobKind.
const std::array<KindRow, 13>& kind_rows();
/// Their keys.
std::vector<std::string> job_kinds();
/// The job kind of a program (KIND_*).
JobKind job_kind(Word kind, const Words& words);

}  // namespace cmrc
