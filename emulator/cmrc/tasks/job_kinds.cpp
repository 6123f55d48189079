#include "cmrc/tasks/job_kinds.hpp"

#include <algorithm>
#include <stdexcept>

namespace cmrc {

const std::array<KindRow, 13>& kind_rows() {
  using W = Config::Watchdog;
  // tests/kernels/test_heartbeat.py counts the beats; the values leave room for delays by the bus.
  static constexpr std::array<KindRow, 13> rows = {{
      {"pid", &Words::kind_pid, &W::servo_run_us, 0},
      {"torque_compensation", &Words::kind_torque, &W::servo_run_us, 0},
      {"trajectory_planning.crane", &Words::kind_trajectory_crane, &W::planning_run_us, 0},
      {"trajectory_planning.agv", &Words::kind_trajectory_agv, &W::planning_run_us, 0},
      {"inverse_kinematics.crane", &Words::kind_inverse_crane, &W::planning_run_us, 0},
      {"inverse_kinematics.agv", &Words::kind_inverse_agv, &W::planning_run_us, 0},
      {"obstacle_avoidance", &Words::kind_avoidance, &W::long_run_us, 750},
      {"identify", &Words::kind_identify, &W::long_run_us, 750},
      {"grab_path", &Words::kind_grab_path, &W::long_run_us, 750},
      {"home.crane", &Words::kind_home_crane, &W::long_run_us, 750},
      {"home.agv", &Words::kind_home_agv, &W::long_run_us, 0},
      {"error", &Words::kind_error, &W::long_run_us, 0},
      {"recompute", nullptr, &W::long_run_us, 0},
  }};
  static_assert(rows.size() == static_cast<std::size_t>(JobKind::user) && !rows.back().name.empty(),
                "each built-in kind has one row, in the order of JobKind");
  return rows;
}

std::vector<std::string> job_kinds() {
  std::vector<std::string> all;
  for (const KindRow& row : kind_rows()) all.emplace_back(row.name);
  return all;
}

JobKind job_kind(Word kind, const Words& words) {
  const auto& rows = kind_rows();
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const KindRow& row) {
    return row.program != nullptr && words.*row.program == kind;
  });
  if (found != rows.end()) return static_cast<JobKind>(found - rows.begin());
  if (kind >= words.kind_user && kind < words.kind_count) {
    return static_cast<JobKind>(static_cast<Word>(JobKind::user) + kind - words.kind_user);
  }
  throw std::invalid_argument("a task block of a kind that has no account");
}

}  // namespace cmrc
