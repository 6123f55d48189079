#include "cmrc/configuration/dock/job_places.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace cmrc {
namespace {

using std::numbers::pi;

/// A heading or its opposite, whichever is nearer to 0: a box fits both ways.
double half_turn(double heading) { return heading - pi * std::floor(heading / pi + 0.5); }

}  // namespace

std::vector<JobPlace> places_of(const plant::DockConfig& dock) {
  const plant::Layout& layout = dock.layout;
  std::vector<JobPlace> places{{"home", dock.home.x, dock.home.y, dock.home.yaw}};
  if (dock.agv_count > 0)
    places.push_back({"the loading spot", layout.spot.x, layout.spot.y, half_turn(layout.spot.heading)});
  for (std::size_t i = 0; i < layout.containers.size(); ++i)
    places.push_back({fmt::format("container {}", i), layout.containers[i].x, layout.containers[i].y, 0.0});
  return places;
}

}  // namespace cmrc
