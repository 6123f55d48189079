#pragma once
// What stands on the dock and what lies below a point: containers wherever they are, AGV decks, the ship, the ground.
#include <array>
#include <vector>

#include "plant/agv.hpp"
#include "plant/dock.hpp"

namespace plant {

struct ContainerData {
  ContainerState state = ContainerState::on_ship;
  int agv = -1;
  double x = 0.0, y = 0.0, z = 0.0, yaw = 0.0;  // centre of the underside; on an AGV relative to its centre and heading
  double mass = 0.0;
};

// An upright box turned about the vertical.
struct Solid {
  double x, y, yaw;            // centre
  double half_x, half_y;       // m
  double bottom, top;          // z
  double sin_yaw, cos_yaw;
  enum class Kind : std::uint8_t { ground, ship, container, agv, fixed, mover, crane } kind;
  int index;                   // container, AGV or mover, else -1
  bool round = false;          // an upright cylinder of radius half_x; what has no use for that takes the box around it
  double vx = 0.0, vy = 0.0, vz = 0.0;  // m/s
};

Solid make_solid(Solid::Kind, int index, double x, double y, double yaw, double half_x, double half_y, double bottom, double top);

// How far the ship is from where it lies in calm water, and how fast it moves: at its middle on the quay's level, m and rad.
struct ShipPlace {
  double surge = 0.0, sway = 0.0, heave = 0.0, roll = 0.0, pitch = 0.0;
  // Of a point of the ship that lies at (x, y, z) in calm water.
  std::array<double, 3> shift(const Box& ship, double x, double y, double z) const;
};
struct ShipNow {
  ShipPlace place, rate;
};
ShipNow ship_at(const DockConfig&, const std::vector<ContainerData>&, double seconds);

// A container's pose in the world. On the ship it moves as its place there does, but stays upright.
ContainerData in_world(const ContainerData&, const std::vector<AgvState>&, const Box& ship, const ShipPlace&);

// Where a mover is, and how fast, at `seconds`.
struct MoverPlace {
  double x, y, vx, vy;
};
MoverPlace place_of(const Mover&, double seconds);

// The legs of a crane that stands at `travel` (m) and travels at `speed` (m/s).
void add_legs(const Portal&, double travel, double speed, std::vector<Solid>& solids);

// Everything solid but the container `without`. Clears and fills `solids`.
void collect_solids(const DockConfig&, const DockState&, int without, std::vector<Solid>& solids);

bool covers(const Solid&, double x, double y);
// Whether two turned rectangles overlap when the first is widened by `margin` on every side.
bool overlaps(const Solid& a, const Solid& b, double margin);

// Mean height of the topmost surface (container or deck) of the bay between two x along the line y, m.
double bay_height(const DockConfig&, const std::vector<ContainerData>&, double seconds, double x_from, double x_to, double y);

}  // namespace plant
