#pragma once
// Detects an unstable loop by its drive's codes: they swing from one end of their range to the other and back, again
// and again.
#include <array>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "plant/dock/dock.hpp"
#include "state/visitor.hpp"

namespace cmrc {

class Instability {
 public:
  struct Found {
    std::size_t joint;
    std::int64_t since;   ///< latch of the first of these swings
    double frequency_hz;  ///< of the oscillation
  };

  /// The codes of a latch. A joint is reported once, when it has begun to swing; and again after a second without a
  /// swing. Several joints may begin in one latch: PID writes all codes in one tick.
  std::vector<Found> latch(std::int64_t number, std::span<const int> codes) {
    std::vector<Found> found;
    for (std::size_t j = 0; j < codes.size() && j < joints_.size(); ++j) {
      Joint& joint = joints_[j];
      if (joint.reported && number - joint.last > window) joint.reported = false, joint.swings.clear();
      const int side = codes[j] >= far ? 1 : codes[j] <= -far ? -1 : 0;
      if (side == 0 || side == joint.side) continue;
      if (joint.side != 0) {
        joint.swings.push_back(number);
        joint.last = number;
      }
      joint.side = side;
      while (!joint.swings.empty() && number - joint.swings.front() > window) joint.swings.pop_front();
      if (joint.reported || joint.swings.size() < enough) continue;
      joint.reported = true;
      const double seconds = static_cast<double>(joint.swings.back() - joint.swings.front()) * plant::latch_seconds;
      found.push_back({j, joint.swings.front(), static_cast<double>(joint.swings.size() - 1) / 2 / seconds});
    }
    return found;
  }

  void list_state(state::Visitor& list) { list("joints", joints_); }

 private:
  static constexpr int far = (4 * plant::largest_torque_code + 2) /
                             5;             // four fifths of the range: no planned motion needs that in both directions
  static constexpr std::size_t enough = 6;  // number of swings: three whole oscillations
  static constexpr std::int64_t window =
      std::chrono::seconds{1} / plant::latch_period;  // latches within which they come
  struct Joint {
    int side = 0;
    std::deque<std::int64_t> swings;
    std::int64_t last = 0;
    bool reported = false;
  };
  std::array<Joint, plant::joint_count> joints_;
};

}  // namespace cmrc
