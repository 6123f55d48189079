// A piece of lane: the place at a distance along it, and the distance from it, are each other's inverse.
#include <doctest/doctest.h>

#include <cmath>

#include "plant/numerics/math.hpp"
#include "plant/parameters/config.hpp"

namespace {

constexpr plant::LaneSegment pieces[] = {
    {3, -2, 0.7, 30, 0, 5},
    {3, -2, 0.7, 30, 1 / 12.0, 3},    // to the left
    {-40, 5, 2.9, 37, -1 / 12.0, 3},  // to the right, about half a turn
};

/// The point `aside` m to the left of the place at `way`.
double distance(const plant::LaneSegment& lane, double way, double aside) {
  const plant::Pose at = plant::along(lane, way);
  const auto [s, c] = plant::sin_cos(at.heading);
  return plant::distance_from(lane, at.x - aside * s, at.y + aside * c);
}

}  // namespace

TEST_CASE("a point beside a lane is as far from it as it is aside") {
  for (const plant::LaneSegment& lane : pieces) {
    for (const double share : {0.0, 0.25, 0.5, 1.0}) {
      for (const double aside : {-5.0, -0.1, 0.0, 0.1, 5.0}) {
        CAPTURE(lane.curvature);
        CAPTURE(share);
        CAPTURE(aside);
        CHECK(distance(lane, share * lane.length, aside) == doctest::Approx(std::abs(aside)).epsilon(1e-9));
      }
    }
  }
}

TEST_CASE("beyond the ends of a straight lane the nearer end counts, and an arc is far") {
  const plant::LaneSegment& straight = pieces[0];
  CHECK(distance(straight, -4, 3) == doctest::Approx(5));
  CHECK(distance(straight, straight.length + 4, -3) == doctest::Approx(5));
  for (const plant::LaneSegment& arc : {pieces[1], pieces[2]}) {
    CHECK(distance(arc, -1, 0) == 1e9);
    CHECK(distance(arc, arc.length + 1, 0) == 1e9);
  }
}
