#pragma once
// ODE's geometry without its dynamics: the object that a ray meets, and the contact of two solids.
#include <array>
#include <memory>
#include <optional>
#include <span>

#include "plant/scene/scene.hpp"

namespace plant {

inline constexpr double range_height = 0.8;  // m above the ground, between an AGV's underside and its deck

// The value of a range register for a distance, mm.
std::int32_t range_code(double distance);

struct Touch {
  double x, y;    // m, middle of their overlap
  double nx, ny;  // horizontal unit vector from the second to the first
  double depth;   // m
};

class Geometry {
 public:
  Geometry();
  ~Geometry();
  Geometry(const Geometry&) = delete;
  Geometry& operator=(const Geometry&) = delete;

  using Scan = std::array<std::int32_t, range_rays>;
  // All rays of a sensor at (x, y) that looks to `heading`, at range_height.
  Scan scan(double x, double y, double heading, std::span<const Solid>);
  // Nothing if they do not overlap, or not in height.
  std::optional<Touch> touch(const Solid&, const Solid&);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> self_;
};

}  // namespace plant
