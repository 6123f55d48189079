#include "report/values/why_late.hpp"

namespace report {

std::string name(Wait wait) {
  static constexpr const char* names[wait_count] = {
      "host_late",   "not_due",     "host_refresh", "host_lock",    "doorbell",         "claim",
      "claim_bus_a", "claim_bus_b", "lock",         "behind_list",  "blocked",          "no_dsp",
      "own_dsp_out", "lost_run",    "watchdog",     "previous_out", "stopped_by_error", "left_out"};
  return names[static_cast<std::size_t>(wait)];
}

std::string name(Run::End end) {
  switch (end) {
    case Run::End::done: return "done";
    case Run::End::part: return "part";
    case Run::End::failed: return "failed";
    case Run::End::taken_away: return "taken_away";
    case Run::End::running: return "running";
  }
  return "unknown";
}

}  // namespace report
