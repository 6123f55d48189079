#include "cmrc/programs/segment_duration.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "cmrc/configuration/dock/servo_law.hpp"
#include "cmrc/programs/program_constants.hpp"
#include "cmrc/tasks/ti_float.hpp"

namespace cmrc {
SegmentDuration::SegmentDuration(const toolchain::Image& image, const Config& config)
    : stretch_(static_cast<double>(intervals(config).crane_slowed) /
               static_cast<double>(intervals(config).crane_point)) {
  const bool shaped = config.kernels.trajectory == TrajectoryBuild::quintic_shaper;
  const std::vector<double> limits = program_constants(image, shaped ? "K_TJ_SHAPED" : "K_TJ_XY1", limits_.size());
  std::ranges::copy(limits, limits_.begin());
  const auto words = speed_words(config.control, plant::CraneKind::slewing);
  for (std::size_t i = 0; i < per_speed_.size(); ++i) per_speed_[i] = from_ti_float(words[i]);
}

double SegmentDuration::seconds(double plan, double height, double turn) const {
  const auto& [plan_1, plan_2, plan_4, height_1, height_2, turn_1, turn_2] = limits_;
  const double in_plan = plan_1 * plan * per_speed_[0];
  // The rotator turns the box, and turns against the slewing.
  const double speed = std::max(height_1 * height * per_speed_[1], in_plan + turn_1 * turn * per_speed_[2]);
  const double square = std::max({plan_2 * plan, std::sqrt(plan_4 * plan), height_2 * height, turn_2 * turn});
  return stretch_ * std::max(speed, std::sqrt(square));
}

}  // namespace cmrc
