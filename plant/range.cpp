#include "plant/range.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "plant/math.hpp"

namespace plant {
namespace {

constexpr double nowhere = std::numeric_limits<double>::infinity();

// Where a line p + t d lies between -half and half; narrows [enter, leave].
void clip(double p, double d, double half, double& enter, double& leave) {
  if (d == 0.0) {
    if (std::fabs(p) > half) enter = nowhere;
    return;
  }
  const double a = (-half - p) / d, b = (half - p) / d;
  enter = std::max(enter, std::min(a, b));
  leave = std::min(leave, std::max(a, b));
}

}  // namespace

double nearest(const RangeRay& ray, const std::vector<Solid>& solids) {
  const auto [s, c] = sin_cos(ray.direction);
  double best = nowhere;
  for (const Solid& solid : solids) {
    if (solid.bottom > range_height || solid.top < range_height) continue;
    const double dx = ray.x - solid.x, dy = ray.y - solid.y;
    double enter = 0.0, leave = nowhere;
    clip(solid.cos_yaw * dx + solid.sin_yaw * dy, solid.cos_yaw * c + solid.sin_yaw * s, solid.half_x, enter, leave);
    clip(solid.cos_yaw * dy - solid.sin_yaw * dx, solid.cos_yaw * s - solid.sin_yaw * c, solid.half_y, enter, leave);
    if (enter <= leave) best = std::min(best, enter);
  }
  return best;
}

std::int32_t range_code(double distance) {
  const double mm = 1e3 * distance;
  if (mm >= range_most) return range_most;
  return std::max(static_cast<std::int32_t>(std::floor(mm / range_quantum)) * range_quantum, range_least / range_quantum * range_quantum);
}

}  // namespace plant
