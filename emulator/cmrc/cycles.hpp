#pragma once
// Times of the processes, cycle by cycle (equations 2 to 4), and learning of N^_a from them (plant-and-bus.md 4.7).
//
// The crane is ready for an AGV when it asks for one (step "wait_for_agv"), else when its process 3 has ended. From then on it waits (t_v) if none
// stands in the loading spot, and an AGV that had come before has waited (t_w), in the spot and in the slots behind it. What follows to the
// start of process 4 is the crane's way to the AGV, which has to stand there (it is aimed at, ruling 9): t_3's for the crane, neither t_w nor
// t_v. So at most one of t_w and t_v is above 0, and
//     T_g = t_3 + t_4 + t_v,    T_a = t_5 + t_6 + t_4 + t_w + approach
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "cmrc/config.hpp"
#include "report/run_report.hpp"

namespace cmrc {

/// What an AGV knows when it is loaded again: how long it drove, and who waited for whom.
struct AgvCycle {
  unsigned agv = 0;
  report::Time driving{};  ///< t_5 + t_6
  report::Time t_w{};      ///< it waited for the crane
  report::Time t_v{};      ///< the crane waited for it
  report::Time T_g{};
};

/// Notes when processes start and end. Cycle n is container n's way, from the start of the n-th process 3.
class Cycles {
 public:
  /// robot: 0 crane, n AGV n - 1; of process 4 the AGV that is loaded.
  void process(unsigned number, bool started, unsigned robot, report::Time now);
  /// The crane holds a container and is ready for an AGV.
  void crane_asks(report::Time now) { asked_ = now; }
  /// A landing of the present cycle has been missed.
  void landing_missed() { if (!cycles_.empty()) ++cycles_.back().landings_missed; }
  /// An AGV has come to its slot of the queue or to the loading spot, or drives on from its slot.
  void agv_waits(unsigned agv, bool waits, report::Time now);
  /// N^_a of the way that an AGV begins.
  void sent(unsigned agv, std::int64_t interval);
  const std::vector<report::CycleReport>& cycles() const { return cycles_; }
  /// Cycles of which process 6 has ended.
  unsigned completed() const { return completed_; }
  /// The cycle that has just closed (its AGV is being loaded again); each is given once.
  std::optional<AgvCycle> take_closed();

 private:
  struct Agv {
    std::size_t cycle = 0;                     // its present one
    bool loaded = false;                       // it has one
    std::optional<report::Time> waits_since;   // in a slot or the spot
    report::Time waited{};                     // in slots that it has left, within the present process 6
  };

  report::CycleReport* of_agv(unsigned agv);
  void loading_begins(unsigned agv, report::Time now);

  std::vector<report::CycleReport> cycles_;
  std::map<unsigned, Agv> agvs_;
  std::map<std::pair<unsigned, unsigned>, report::Time> started_;  // (process, robot)
  std::optional<report::Time> asked_;                              // in the present cycle of the crane
  report::Time grabbed_{};                                         // end of its process 3
  std::optional<AgvCycle> closed_;
  unsigned completed_ = 0;
};

/// The new N^_a of an AGV after a cycle. \param agvs number of AGVs: with n of them t_v counts n times
std::int64_t learned_interval(const Config::Scheduling& rule, std::int64_t present, std::int64_t lowest, unsigned agvs, const AgvCycle& cycle);

}  // namespace cmrc
