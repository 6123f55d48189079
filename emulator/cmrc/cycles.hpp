#pragma once
// Times of the processes, cycle by cycle (equations 2 to 4), and learning of N^_a from them (plant-and-bus.md 4.7).
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "cmrc/config.hpp"
#include "report/run_report.hpp"

namespace cmrc {

/// Notes when processes start and end. Cycle n is container n's way, from the start of the n-th process 3.
class Cycles {
 public:
  /// robot: 0 crane, n AGV n - 1; of process 4 the AGV that is loaded.
  void process(unsigned number, bool started, unsigned robot, report::Time now);
  /// The crane holds a container and waits for an AGV before it begins leg 2: part of t_v, not of t_3.
  void crane_waits(bool waits, report::Time now);
  const std::vector<report::CycleReport>& cycles() const { return cycles_; }
  /// Cycles of which process 6 has ended.
  unsigned completed() const { return completed_; }
  /// The cycle whose t_w has just become known (its AGV is being loaded again); each is given once.
  std::optional<report::CycleReport> take_closed();

 private:
  report::CycleReport* of_agv(unsigned agv);
  void loading_begins(unsigned agv, report::Time now);

  std::vector<report::CycleReport> cycles_;
  std::map<unsigned, std::size_t> agv_cycle_;     // the AGV's present cycle
  std::map<unsigned, report::Time> agv_free_;     // end of its process 6
  std::map<std::pair<unsigned, unsigned>, report::Time> started_;  // (process, robot)
  report::Time crane_ready_{};
  report::Time waiting_{};                        // within the present process 3
  std::optional<report::Time> waiting_since_;
  std::optional<report::CycleReport> closed_;
  unsigned completed_ = 0;
};

/// The new N^_a after a cycle. \param agvs number of AGVs: with n of them t_v counts n times
std::int64_t learned_interval(const Config::Scheduling& rule, std::int64_t present, std::int64_t lowest, unsigned agvs,
                              const report::CycleReport& cycle);

}  // namespace cmrc
