#pragma once
// What the dock tells its observers: true values, no sensors.
#include <array>
#include <cstdint>

#include "plant/dock/dock_event.hpp"
#include "plant/parameters/basics.hpp"

namespace plant {

enum class ContainerState : std::uint8_t { on_ship, carried, on_agv, on_ground, delivered };

struct ContainerStatus {
  ContainerState state;
  int agv;                   // carrier, or -1
  double x, y, z, yaw;       // m, rad: centre of the top
  std::array<double, 3> up;  // unit vector out of the top: a container on a rolling ship tilts with it
  double mass;               // kg
};

// The phase of a container's hand-over.
enum class HandoverPhase : std::uint8_t {
  free,     // hangs on the ideal rope
  align,    // near something on which it can land
  landed,   // all four corners closed
  lock,     // twist locks turning
  tension,  // they have turned; the rope takes the weight
  lift,     // off the surface
};
const char* name(HandoverPhase);

struct Handover {
  HandoverPhase phase;
  bool releasing;  // a container is under the spreader (in tension and lift: was set down)
  int attempts;    // touches since the payload last hung free; all after the first are retries
};

// How a change of the payload's model or mass changed energy and momentum.
struct Momentum {
  std::array<double, 3> payload;  // kg m/s
  double spin;                    // kg m2/s of the payload about its own vertical
  double travel, slewing;         // of everything: along the quay, kg m/s, and about the slewing axis, kg m2/s
};
struct PayloadChange {
  Time time;
  EventKind kind;                      // near_contact, free_again, locked (attached), opened (detached)
  int container;                       // or -1
  double energy_before, energy_after;  // J, crane and payload; and what was detached or attached, if it moved
  Momentum before, after;
};

struct AgvSignal {
  double x, y, heading, speed, yaw_rate, front, rear, speed_command;
};

// One row of the recorded signals, taken at a latch. q in joint units.
struct Signal {
  Time time;
  std::array<double, joint_count> q, qd, torque;  // torque: motor side, N m, behind the lag
  std::array<int, joint_count> code;              // as latched
  double alpha, beta;                             // rad
  std::array<double, 3> tip, payload;             // m
  double yaw;                                     // rad, payload in the world
  double tension;                                 // N, sum of the falls
  bool contact;
};

// The places of crane and load: the part of a Signal that is cheap to compute.
struct Place {
  std::array<double, joint_count> q;
  double alpha, beta;             // rad
  std::array<double, 3> payload;  // m
};

// The attitude of the load and the ship.
struct Attitude {
  std::array<double, 3> load_up;     // unit vector out of the load's top: near contact the load is a body and tilts
  std::array<double, 3> ship_shift;  // m from the ship's place in calm water
  std::array<double, 3> ship_up;     // unit vector out of its deck; the ship does not turn about it
};

}  // namespace plant
