#pragma once
// Times of the processes, cycle by cycle (equations 2 to 4), and learning of N^_a from these times (plant-and-bus.md
// 4.7). The row of a process says whether it counts as t_3, t_4, t_5 or t_6 (`account`).
//
// The crane waits for an AGV (t_v) from the end of t_3, above the loading spot, to the start of t_4. An AGV waits from
// leaving the lane, at its first stop in a slot or the spot, to the end of the t_4 that loads it again; moving up is
// t_6. So t_wait = t_w + that t_4, and
//     T_g = t_3 + t_4 + t_v,    T_a = t_5 + t_6 + t_wait
// are the times from one beginning of t_3, and from one end of t_4, to the next.
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "report/values/run_report.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

/// Times of an AGV's cycle, known when the AGV is loaded again.
struct AgvCycle {
  unsigned agv = 0;
  report::Time driving{};  ///< t_5 + t_6
  report::Time t_w{};      ///< the AGV waited for the crane
  report::Time t_v{};      ///< the crane waited for the AGV
  report::Time T_g{};
};

/// Records the starts and ends of processes. Cycle n belongs to container n, and begins at the n-th start of t_3.
class ContainerCycles {
 public:
  /// robot: 0 crane, n AGV n - 1; for t_4 the AGV that is loaded.
  void process(Account account, bool started, unsigned robot, report::Time now);
  /// A landing of the present cycle was missed.
  void landing_missed() {
    if (!cycles_.empty()) ++cycles_.back().landings_missed;
  }
  /// An AGV has reached its slot of the queue or the loading spot, or leaves its slot.
  void agv_waits(unsigned agv, bool waits, report::Time now);
  /// N^_a of the cycle that an AGV begins.
  void sent(unsigned agv, std::int64_t interval);
  const std::vector<report::CycleReport>& cycles() const { return cycles_; }
  /// Number of cycles whose t_6 has ended.
  unsigned completed() const { return completed_; }
  /// The cycle that has just ended (its AGV is being loaded again); each is returned once.
  std::optional<AgvCycle> take_closed();
  void list_state(state::Visitor& list);

 private:
  struct Agv {
    std::optional<std::size_t> cycle;         // the AGV's present cycle
    std::optional<std::size_t> before;        // the cycle whose wait ends with the present t_4
    std::optional<report::Time> waits_since;  // in a slot or the spot
    report::Time waited{};                    // in slots that the AGV has left, within the present t_6
  };

  report::CycleReport* of_agv(unsigned agv);
  void loading_begins(unsigned agv, report::Time now);
  void loading_ends(unsigned agv, report::Time lasted);

  std::vector<report::CycleReport> cycles_;
  std::map<unsigned, Agv> agvs_;
  std::map<std::pair<Account, unsigned>, report::Time> started_;  // (account, robot)
  std::optional<report::Time> grabbed_;                           // end of the present cycle's t_3
  std::optional<AgvCycle> closed_;
  unsigned completed_ = 0;
};

/// The new N^_a of an AGV after a cycle. \param agvs number of AGVs: with n of them t_v counts n times
std::int64_t learned_interval(const Config::Scheduling& rule, std::int64_t present, std::int64_t lowest, unsigned agvs,
                              const AgvCycle& cycle);

}  // namespace cmrc
