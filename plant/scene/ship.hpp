#pragma once
// The moored ship as a rigid body (plant-and-bus.md 1.5): objects on it move and tilt with it.
#include <vector>

#include "plant/numerics/frame.hpp"
#include "plant/parameters/config.hpp"

namespace plant {

struct ContainerData;

// Turned about its middle at the quay's level by R = R_y(pitch) R_x(roll), and shifted.
struct ShipPose {
  bool moves = false;  // if false, the rest has no meaning: every point of the ship is at its place in calm water
  Vector3 middle{};    // in calm water, m
  Vector3 shift{};     // surge, sway, heave, m
  Frame turn;
  Vector3 velocity{}, spin{};  // of the middle, m/s; in world axes, rad/s

  Vector3 at(const Vector3& calm) const;     // the present place of a point, given its place in calm water
  Vector3 calm(const Vector3& world) const;  // the inverse
  Vector3 velocity_at(const Vector3& world) const;
};

// At `seconds`; a container that has left the ship raises it.
ShipPose ship_at(const DockConfig&, const std::vector<ContainerData>&, double seconds);

}  // namespace plant
