#include "report/run_report.hpp"

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

std::uint64_t RunReport::misses() const {
  std::uint64_t sum = 0;
  for (const TaskReport& task : tasks) sum += task.misses;
  return sum;
}

}  // namespace report
