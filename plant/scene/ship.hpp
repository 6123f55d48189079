#pragma once
// The moored ship as a rigid body (plant-and-bus.md 1.5): what stands on it moves and tilts with it.
#include <vector>

#include "plant/numerics/frame.hpp"
#include "plant/parameters/config.hpp"

namespace plant {

struct ContainerData;

// Turned about its middle at the quay's level by R = R_y(pitch) R_x(roll), and shifted.
struct ShipPose {
  bool moves = false;  // if not, the rest means nothing: every point of the ship is where it is in calm water
  Vector3 middle{};    // in calm water, m
  Vector3 shift{};     // surge, sway, heave, m
  Frame turn;
  Vector3 velocity{}, spin{};  // of the middle, m/s; in world axes, rad/s

  Vector3 at(const Vector3& calm) const;     // where the point is that is here in calm water
  Vector3 calm(const Vector3& world) const;  // and back
  Vector3 velocity_at(const Vector3& world) const;
};

// At `seconds`; what has left the ship raises it.
ShipPose ship_at(const DockConfig&, const std::vector<ContainerData>&, double seconds);

}  // namespace plant
