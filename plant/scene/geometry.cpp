#include "plant/scene/geometry.hpp"

#include <ode/ode.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "plant/numerics/math.hpp"
#include "plant/numerics/ode_start.hpp"

namespace plant {
namespace {

constexpr double farthest = 1e-3 * range_most + 1.0;  // m

// A solid as a box or cylinder of ODE.
class Shape {
 public:
  Shape() : box_(dCreateBox(nullptr, 1, 1, 1)), cylinder_(dCreateCylinder(nullptr, 1, 1)) {}
  ~Shape() {
    dGeomDestroy(box_);
    dGeomDestroy(cylinder_);
  }
  Shape(const Shape&) = delete;
  Shape& operator=(const Shape&) = delete;

  dGeomID place(const Solid& s) const {
    if (!s.tilted) return upright(s, s.bottom, s.top);
    dGeomBoxSetLengths(box_, 2 * s.half_x, 2 * s.half_y, s.top - s.bottom);
    const Vector3 middle = s.middle();
    dGeomSetPosition(box_, middle[0], middle[1], middle[2]);
    const Matrix3 r = s.frame().axes;
    const dMatrix3 turn = {r(0, 0), r(0, 1), r(0, 2), 0, r(1, 0), r(1, 1), r(1, 2), 0, r(2, 0), r(2, 1), r(2, 2), 0};
    dGeomSetRotation(box_, turn);
    return box_;
  }
  dGeomID upright(const Solid& s, double bottom, double top) const {
    auto* const geom = s.round ? cylinder_ : box_;
    if (s.round)
      dGeomCylinderSetParams(cylinder_, s.half_x, top - bottom);
    else
      dGeomBoxSetLengths(box_, 2 * s.half_x, 2 * s.half_y, top - bottom);
    dGeomSetPosition(geom, s.x, s.y, 0.5 * (bottom + top));
    const dMatrix3 turn = {s.cos_yaw, -s.sin_yaw, 0, 0, s.sin_yaw, s.cos_yaw, 0, 0, 0, 0, 1, 0};
    dGeomSetRotation(geom, turn);
    return geom;
  }

 private:
  dGeomID box_, cylinder_;
};

bool within(const Solid& s, double x, double y) {
  if (!s.round) return covers(s, x, y);
  return (x - s.x) * (x - s.x) + (y - s.y) * (y - s.y) <= s.half_x * s.half_x;
}

double reach(const Solid& s) { return std::sqrt(s.half_x * s.half_x + s.half_y * s.half_y); }

}  // namespace

std::int32_t range_code(double distance) {
  const double mm = 1e3 * distance;
  if (mm >= range_most) return range_most;
  return std::max(static_cast<std::int32_t>(std::floor(mm / range_quantum)) * range_quantum,
                  range_least / range_quantum * range_quantum);
}

struct Geometry::Implementation {
  Shape first, second;
  dGeomID ray = dCreateRay(nullptr, farthest);
  Implementation() = default;
  ~Implementation() { dGeomDestroy(ray); }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;
};

Geometry::Geometry() {
  start_ode();
  self_ = std::make_unique<Implementation>();
}
Geometry::~Geometry() = default;

Geometry::Scan Geometry::scan(double x, double y, double heading, std::span<const Solid> solids) {
  start_ode();
  std::array<double, range_rays> nearest;
  nearest.fill(std::numeric_limits<double>::infinity());
  std::array<SinCos, range_rays> toward;
  for (std::size_t i = 0; i < range_rays; ++i)
    toward[i] = sin_cos(heading + 1e-6 * (range_first + static_cast<int>(i) * range_step));
  for (const Solid& solid : solids) {
    if (solid.bottom > range_height || solid.top < range_height) continue;
    const double dx = solid.x - x, dy = solid.y - y;
    const double far = farthest + reach(solid);
    if (dx * dx + dy * dy > far * far) continue;
    if (within(solid, x, y)) nearest.fill(0.0);
    auto* const geom = self_->first.place(solid);
    for (std::size_t i = 0; i < range_rays; ++i) {
      const auto [s, c] = toward[i];
      if (std::fabs(c * dy - s * dx) > reach(solid) || c * dx + s * dy < -reach(solid)) continue;
      dGeomRaySet(self_->ray, x, y, range_height, c, s, 0.0);
      dContactGeom contact;
      if (dCollide(self_->ray, geom, 1, &contact, sizeof contact) > 0) nearest[i] = std::min(nearest[i], contact.depth);
    }
  }
  Scan codes;
  std::transform(nearest.begin(), nearest.end(), codes.begin(), range_code);
  return codes;
}

std::optional<Touch> Geometry::touch(const Solid& a, const Solid& b) {
  if (a.bottom >= b.top || b.bottom >= a.top) return std::nullopt;
  const double dx = a.x - b.x, dy = a.y - b.y;
  const double near = reach(a) + reach(b);
  if (dx * dx + dy * dy > near * near) return std::nullopt;
  start_ode();
  // Both as tall pillars of equal height, so that the shortest way out is always sideways.
  constexpr double pillar = 50.0;  // m
  std::array<dContactGeom, 8> contacts;
  const int n =
      dCollide(self_->first.upright(a, -pillar, pillar), self_->second.upright(b, -pillar - 1.0, pillar + 1.0),
               static_cast<int>(contacts.size()), contacts.data(), sizeof(dContactGeom));
  Touch sum{};
  for (int i = 0; i < n; ++i) {
    const dContactGeom& c = contacts[static_cast<std::size_t>(i)];
    sum.x += c.pos[0] / n;
    sum.y += c.pos[1] / n;
    sum.nx += c.normal[0];
    sum.ny += c.normal[1];
    sum.depth = std::max(sum.depth, c.depth);
  }
  const double length = std::sqrt(sum.nx * sum.nx + sum.ny * sum.ny);
  if (n == 0 || length == 0.0) return std::nullopt;
  sum.nx /= length;
  sum.ny /= length;
  return sum;
}

}  // namespace plant
