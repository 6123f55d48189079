#pragma once
// The places of the crane's job, and the ways between them.
#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "plant/dock/dock.hpp"

namespace cmrc {

struct JobPlace {
  std::string name;
  double x, y, yaw;
  double z = 0;                     // of the spreader's underside at the end of a way
  std::optional<double> carried{};  // the same at the end of a way with a container; none: no such way ends here
};

/// The home position, the loading spot if there are AGVs, and each container; their heights are not set.
std::vector<JobPlace> places_of(const plant::DockConfig& dock);

/// Calls `check` with both ends of each way of the job. No way leads from container to container.
template <class Check>
void each_way(const std::vector<JobPlace>& places, const plant::DockConfig& dock, Check check) {
  const std::size_t ends = std::min<std::size_t>(places.size(), dock.agv_count > 0 ? 2 : 1);
  for (std::size_t from = 0; from < ends; ++from)
    for (std::size_t to = from + 1; to < places.size(); ++to) check(places[from], places[to]);
}

}  // namespace cmrc
