#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "plant/crane/crane.hpp"
#include "plant/numerics/frame.hpp"
#include "plant/numerics/math.hpp"

namespace plant {
namespace {

CraneVector within_limits(const CraneParameters& p, const CraneVector& q) {
  const bool gantry = p.machine == CraneKind::gantry;
  const std::array names{"gantry", "slew", gantry ? "trolley" : "luff", "hoist", "rotator"};
  for (std::size_t j = 0; j < joint_count; ++j) {
    const double value = q[coordinate_of(j)];
    if (!(value >= p.lower[j] && value <= p.upper[j]))
      throw std::invalid_argument(fmt::format("plant: the pose needs {} = {}, outside its limits {} to {}", names[j],
                                              value, p.lower[j], p.upper[j]));
  }
  return q;
}

}  // namespace

CraneVector inverse_kinematics(const CraneParameters& p, const CranePose& pose) {
  CraneVector q{};
  if (p.machine == CraneKind::gantry) {
    q[Q_S] = pose.x;  // pose.s is the required place of the gantry
    q[Q_PSI] = 0.5 * std::numbers::pi;
    q[Q_PHI] = pose.y;
    q[Q_L] = p.pivot_height - pose.z;
    q[Q_KAPPA] = wrap_angle(pose.yaw - q[Q_PSI]);
    return within_limits(p, q);
  }
  const double dx = pose.x - pose.s;
  const double radius = std::sqrt(dx * dx + pose.y * pose.y);
  const double c = (radius - p.a0) / p.jib;
  if (!(c >= -1.0 && c <= 1.0))
    throw std::invalid_argument(
        fmt::format("plant: pose ({} m, {} m) is {} m from the crane's column; the jib reaches {} to {} m", pose.x,
                    pose.y, radius, p.a0, p.a0 + p.jib));
  const double s = std::sqrt(1.0 - c * c);
  q[Q_S] = pose.s;
  q[Q_PSI] = atan2(pose.y, dx);
  q[Q_PHI] = atan2(s, c);
  q[Q_L] = p.pivot_height + p.jib * s - pose.z;
  q[Q_KAPPA] = wrap_angle(pose.yaw - q[Q_PSI]);
  return within_limits(p, q);
}

}  // namespace plant
