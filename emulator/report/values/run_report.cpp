#include "report/values/run_report.hpp"

#include <algorithm>

namespace report {

std::string name(StopReason reason) {
  switch (reason) {
    case StopReason::under_way: return "under_way";
    case StopReason::completed: return "completed";
    case StopReason::interrupted: return "interrupted";
    case StopReason::no_dsp_left: return "no_dsp_left";
    case StopReason::plant_fault: return "plant_fault";
    case StopReason::drives_stopped: return "drives_stopped";
    case StopReason::job_done: return "job_done";
  }
  return "unknown";
}

bool RunReport::judged() const {
  return std::ranges::any_of(tasks, [](const TaskReport& task) { return task.on_time + task.misses > 0; });
}

std::uint64_t RunReport::misses() const {
  std::uint64_t sum = 0;
  for (const TaskReport& task : tasks) sum += task.misses;
  return sum;
}

}  // namespace report
