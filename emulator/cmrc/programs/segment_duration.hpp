#pragma once
// How long a slewing crane's trajectory takes for a segment of its way (docs/kernels.md, Durations): with the constants
// of the DSPs' program and the words of CR_SPEED, as the kernel computes it.
#include <array>

#include "cmrc/configuration/config.hpp"
#include "toolchain/objects/image.hpp"

namespace cmrc {

class SegmentDuration {
 public:
  /// \param image with K_TJ_XY1 to K_TJ_YAW2, or for kernels.trajectory = "quintic_shaper" K_TJ_SHAPED
  /// \throws ConfigError if the image lacks them
  SegmentDuration(const toolchain::Image& image, const Config& config);

  /// Seconds for `plan` and `height` m and `turn` rad, none of them negative, in the configuration's work mode. Of a
  /// crane whose look-ahead stretches the leg (quintic_shaper) it is the shortest.
  double seconds(double plan, double height, double turn) const;

 private:
  std::array<double, 7> limits_;     // c of T >= c h / v, T^2 >= c h and T^4 >= c h, in the order of the constants
  std::array<double, 3> per_speed_;  // 1 / v in plan, vertically and in yaw
  double stretch_;                   // CR_STRETCH, 1 unless the crane is slowed
};

}  // namespace cmrc
