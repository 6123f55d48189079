#pragma once
// ODE's geometry without its dynamics: what a ray meets, and where two solids touch.
#include <array>
#include <memory>
#include <optional>
#include <span>

#include "plant/scene/scene.hpp"

namespace plant {

inline constexpr double range_height = 0.8;  // m above the ground, between an AGV's underside and its deck

// What a range register shows for a distance, mm.
std::int32_t range_code(double distance);

struct Touch {
  double x, y;    // m, middle of where they overlap
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
  // Nothing if they are apart, or do not share a height.
  std::optional<Touch> touch(const Solid&, const Solid&);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> self_;
};

}  // namespace plant
