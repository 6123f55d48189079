#pragma once
// What a horizontal range sensor on an AGV sees: rays against the upright boxes of the scene.
//
// Inaccuracies: the scan is taken at the AGVs' last 1-ms step before the read, all rays at once; no noise, no missed echoes.
#include <vector>

#include "plant/scene.hpp"

namespace plant {

inline constexpr double range_height = 0.8;  // m above the ground, between an AGV's underside and its deck

struct RangeRay {
  double x, y, direction;  // m, rad in the world
};

/// Distance to the first box that the ray meets at the sensor's height, m; infinity when there is none.
double nearest(const RangeRay&, const std::vector<Solid>&);
/// What the register shows for a distance, mm.
std::int32_t range_code(double distance);

}  // namespace plant
