#pragma once
// The objects on the dock, and the surface below a point: containers in any place, AGV decks, the ship, the ground.
#include <functional>
#include <vector>

#include "plant/dock/dock_values.hpp"
#include "plant/parameters/config.hpp"
#include "plant/scene/ship.hpp"
#include "plant/vehicles/agv.hpp"

namespace plant {

struct DockState;  // plant/dock/state.hpp

struct ContainerData {
  ContainerState state = ContainerState::on_ship;
  int agv = -1;
  double x = 0.0, y = 0.0, z = 0.0, yaw = 0.0;  // centre of the underside; on an AGV relative to its centre and heading
  double mass = 0.0;
  bool from_ship = true;  // it was on the ship at the start
};

// A box turned about the vertical by yaw; on a rolling ship then tilted about the middle of its top.
struct Solid {
  double x, y, yaw;       // middle of the top, m, rad
  double half_x, half_y;  // m
  double bottom, top;     // z; if tilted, of the top's middle, and below it by the solid's height
  double sin_yaw, cos_yaw;
  enum class Kind : std::uint8_t { ground, ship, container, agv, fixed, mover, crane } kind;
  int index;           // container, AGV or mover, else -1
  bool round = false;  // an upright cylinder of radius half_x; a user that does not need this takes the box around it
  double vx = 0.0, vy = 0.0, vz = 0.0;  // of the top's middle, m/s
  bool tilted = false;
  Frame tilt{};
  Vector3 spin{};  // rad/s

  double top_at(double px, double py) const;  // height of the top's plane there
  Vector3 velocity_at(const Vector3&) const;
  Vector3 middle() const;  // of the whole solid
  Frame frame() const;     // its own axes: yaw, then tilt
};

Solid make_solid(Solid::Kind, int index, double x, double y, double yaw, double half_x, double half_y, double bottom,
                 double top);

Solid solid_of(Solid::Kind, const Box&);
Solid solid_of(const AgvParameters&, int index, double x, double y, double heading);

// A container as a solid, in any place. A container that is not visible (carried, delivered) is at its last place.
Solid solid_of(const ContainerData&, int index, const std::vector<AgvState>&, const ShipPose&);

// A container at its place at the start: on the ship if it stands there, or on a container that does.
bool stands_on_ship(const Layout&, const ContainerPlace&);

// The place and speed of a mover at `seconds`.
struct MoverPlace {
  double x, y, vx, vy;
};
MoverPlace place_of(const Mover&, double seconds);

using VisitSolid = std::function<void(const Solid&)>;
// The legs of a crane with travel position `travel` (m) and speed `speed` (m/s).
void each_leg(const Portal&, double travel, double speed, const VisitSolid& visit);

// All solids except the container `without`, one after the other.
void each_solid(const DockConfig&, const DockState&, int without, const VisitSolid& visit);
// The same into `solids`, which is cleared first.
void collect_solids(const DockConfig&, const DockState&, int without, std::vector<Solid>& solids);

bool covers(const Solid&, double x, double y);
// Whether two rotated rectangles overlap if the first is widened by `margin` on every side.
bool overlaps(const Solid& a, const Solid& b, double margin);

// Mean height of the topmost surface (container or deck) of the bay between two x along the line y, m.
double bay_height(const DockConfig&, const DockState&, double x_from, double x_to, double y);

}  // namespace plant
