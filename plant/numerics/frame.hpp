#pragma once
// Turned frames, and Eigen's fixed-size types as the plant uses them: without packets, so that the order of a sum is
// that of the source at every level of optimisation and by every compiler. Private to this room (the headers below are
// heavy).
#include <array>

#include "plant/numerics/vector.hpp"

#ifdef EIGEN_CORE_H
#error "Eigen is included by plant/numerics/frame.hpp alone, which sets how"
#endif
#define EIGEN_DONT_VECTORIZE
#define EIGEN_NO_DEBUG  // sizes are fixed: what is left to assert are indices that are constants
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace plant {

using Matrix3 = Eigen::Matrix3d;
inline Eigen::Map<const Eigen::Vector3d> eigen(const Vector3& v) { return Eigen::Map<const Eigen::Vector3d>(v.data()); }
template <class Expression>
Vector3 vector_of(const Eigen::MatrixBase<Expression>& expression) {
  Vector3 v;
  Eigen::Map<Eigen::Vector3d>(v.data()) = expression;
  return v;
}

// A turned frame: its axes in the world are the columns. Eigen's AngleAxis is of no use here: it calls the C library's
// sin and cos (plant/numerics/math.hpp says why not).
struct Frame {
  Matrix3 axes = Matrix3::Identity();

  Frame() = default;
  explicit Frame(const Matrix3& columns) : axes(columns) {}
  explicit Frame(const std::array<double, 4>& q)  // quaternion w, x, y, z
      : axes(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix()) {}
  Vector3 axis(int i) const { return vector_of(axes.col(i)); }
  Vector3 operator()(const Vector3& v) const { return vector_of(axes * eigen(v)); }
  Vector3 inverse(const Vector3& v) const { return vector_of(axes.transpose() * eigen(v)); }
};

}  // namespace plant
