#pragma once
// Sway of the load, and distance of each vehicle from the lane while it drives, from samples each 10 ms: independent of
// how often signals are recorded.
#include <array>
#include <vector>

#include "cmrc/measures/square_sum.hpp"
#include "plant/dock/dock.hpp"
#include "state/visitor.hpp"

namespace cmrc {

class MotionWatch {
 public:
  /// The first sample is the dock as it is now.
  explicit MotionWatch(const plant::Dock& dock) : agvs_(static_cast<std::size_t>(dock.agv_count())) { sample(dock); }

  /// The dock is at a latch.
  void latch(const plant::Dock& dock, plant::Time time) {
    if (time % period == plant::Time{}) sample(dock);
  }
  const std::array<SquareSum, 2>& sway() const { return sway_; }  ///< alpha, beta; rad
  const std::vector<SquareSum>& agvs() const { return agvs_; }    ///< m
  void list_state(state::Visitor& list) {
    list("sway", sway_);
    list("agvs", agvs_);
  }

 private:
  void sample(const plant::Dock& dock);

  static constexpr plant::Time period = plant::tick_latches * plant::latch_period;  // 10 ms
  static constexpr double drives = 0.05;                                            // m/s: a slower one stands
  std::array<SquareSum, 2> sway_;
  std::vector<SquareSum> agvs_;
};

}  // namespace cmrc
