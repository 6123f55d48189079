#pragma once
// AGVs and their obstacles: impacts with each other and with objects on the dock, and the protective field of a
// vehicle's own range sensor.
//
// Inaccuracies: impacts are plastic and without friction between the bodies; movers and containers on the ground do not
// move.
#include <functional>
#include <utility>
#include <vector>

#include "plant/dock/state.hpp"
#include "plant/scene/geometry.hpp"

namespace plant {

class Traffic {
 public:
  explicit Traffic(DockConfig config) : config_(std::move(config)) {}

  // Called with an AGV that has just collided: its number, the other's (-1: not an AGV), their closing speed in m/s.
  using Hear = std::function<void(std::size_t agv, int other, double speed)>;
  // To be called after the AGVs have moved: AGVs that collided share their momentum, and their bumpers stop them.
  void collide(std::vector<AgvState>&, const std::vector<Solid>&, const Hear&);

  Geometry::Scan scan(const AgvState&, std::size_t agv, const std::vector<Solid>&);
  // m from the vehicle's front to the nearest echo in its way: its path with the present steering, 0.3 m wider on
  // either side; infinity: none.
  double free_way(const AgvState&, const Geometry::Scan&) const;
  // The greatest speed at which the vehicle can still stop before an object of a scan in its way, m/s; infinity: none.
  double allowed_speed(const AgvState&, const Geometry::Scan&) const;

 private:
  Solid shape(const AgvState&, std::size_t agv) const;
  bool impact(AgvState& agv, AgvState* other, const Solid& obstacle, const Touch&, double& speed) const;

  DockConfig config_;
  Geometry geometry_;
  std::vector<Solid> others_;  // scratch
};

}  // namespace plant
