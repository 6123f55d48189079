#pragma once
// Vectors and turned frames in the world: x along the quay, y towards the ship, z up.
#include <array>
#include <cmath>

namespace plant {

using Vector3 = std::array<double, 3>;
inline Vector3 operator+(const Vector3& a, const Vector3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vector3 operator-(const Vector3& a, const Vector3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vector3 operator*(double k, const Vector3& a) { return {k * a[0], k * a[1], k * a[2]}; }
inline double dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double length(const Vector3& a) { return std::sqrt(dot(a, a)); }

// A turned frame: its axes in the world.
struct Frame {
  std::array<Vector3, 3> column = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

  Frame() = default;
  explicit Frame(const std::array<double, 4>& quaternion) {  // w, x, y, z
    const auto [w, x, y, z] = quaternion;
    column[0] = {1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)};
    column[1] = {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)};
    column[2] = {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)};
  }
  Vector3 operator()(const Vector3& v) const { return v[0] * column[0] + v[1] * column[1] + v[2] * column[2]; }
  Vector3 inverse(const Vector3& v) const { return {dot(column[0], v), dot(column[1], v), dot(column[2], v)}; }
};

}  // namespace plant
