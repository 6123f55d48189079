#include "cmrc/measures/motion_watch.hpp"

#include <algorithm>

namespace cmrc {

void MotionWatch::sample(const plant::Dock& dock) {
  const plant::Place place = dock.place();
  sway_[0].add(place.alpha);
  sway_[1].add(place.beta);
  for (std::size_t i = 0; i < agvs_.size(); ++i) {
    const plant::AgvSignal agv = dock.agv(static_cast<int>(i));
    if (agv.speed < drives) continue;
    double nearest = 1e9;
    for (const auto& leg : dock.config().layout.legs) {
      for (const plant::LaneSegment& lane : leg) nearest = std::min(nearest, plant::distance_from(lane, agv.x, agv.y));
    }
    agvs_[i].add(nearest);
  }
}

}  // namespace cmrc
