#pragma once
// Where the parts of spreader and container are, for the files of the landing. Private to them.
#include <cmath>

#include "plant/landing/landing.hpp"
#include "plant/numerics/math.hpp"

namespace plant {

inline constexpr double spreader_centre = 0.75;  // m, its centre of mass above its underside, with the headblock
inline constexpr double casting_x = 5.9925,
                        casting_y = 1.1295;  // m, corner castings of a 40-ft container from its middle
inline constexpr std::array<std::array<double, 2>, 4> corner_sign = {{{1, 1}, {1, -1}, {-1, -1}, {-1, 1}}};

inline double yaw_of(const Frame& frame) { return atan2(frame.axes(1, 0), frame.axes(0, 0)); }

inline double box_inertia(double mass, double a, double b) { return mass * (a * a + b * b) / 12.0; }

inline double container_mass(const DockState& s) {
  return s.carried < 0 ? 0.0 : s.containers[static_cast<std::size_t>(s.carried)].mass;
}

// The middle of the spreader's underside, in the body's frame.
inline Vector3 underside(const DockState& s, double spreader_mass) {
  const double mc = container_mass(s);
  const double middle = s.grip.top - 0.5 * container_height;  // the container's centre above the underside
  return {0.0, 0.0, -(spreader_mass * spreader_centre + mc * middle) / (spreader_mass + mc)};
}

// Where the castings of a container or of an AGV's deck are, in the order of our corners: the nearer of the two ways
// round.
inline Vector3 casting(const Solid& solid, double yaw, std::size_t corner, double z) {
  const bool turned = std::fabs(wrap_angle(yaw - solid.yaw)) > 0.5 * std::numbers::pi;
  const double flip = turned ? -1.0 : 1.0;
  const double dx = flip * corner_sign[corner][0] * casting_x;
  const double dy = flip * corner_sign[corner][1] * casting_y;
  if (solid.tilted) {
    const Vector3 from_middle = solid.frame()({dx, dy, 0.0});
    return {solid.x + from_middle[0], solid.y + from_middle[1], z};
  }
  return {solid.x + solid.cos_yaw * dx - solid.sin_yaw * dy, solid.y + solid.sin_yaw * dx + solid.cos_yaw * dy, z};
}

inline bool has_castings(const Solid& solid) {
  return solid.kind == Solid::Kind::container || solid.kind == Solid::Kind::agv;
}

inline double horizontal_distance(const Vector3& a, const Vector3& b) {
  return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]));
}

// Velocity of a body's point given in world axes from the centre of mass.
inline Vector3 point_velocity(const BodyState& b, const Vector3& arm) { return b.velocity + cross(b.spin, arm); }

}  // namespace plant
