#pragma once
// What can happen on the dock. Each kind is an entry of EventKind and its row in dock_event.cpp.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "plant/parameters/basics.hpp"

namespace plant {

enum class EventKind : std::uint8_t {
  near_contact,   // the payload became a body: values = clearance m, energy jump J
  free_again,     // it hangs on the ideal rope again: values = clearance m, energy jump J
  touch,          // first contact: values = vertical speed, horizontal speed m/s (down positive)
  hard_landing,   // that touch was outside the tolerances: same values
  landed,         // all four corner switches closed
  lifted,         // all four open again
  locked,         // twist locks locked; index = container, -1: none under the spreader
  opened,         // twist locks open; index = container that was let go, -1: none
  refused,        // the twist locks turned back: the landing was lost, or the command changed, before they were locked
  set_on_agv,     // container index stands on AGV values[0]
  agv_dry,        // AGV index: it had no set-points left while driving
  agv_overflow,   // AGV index: a set-point was pushed into a full FIFO and dropped
  agv_arrived,    // AGV index stands loaded in the warehouse spot
  delivered,      // container index, taken from AGV values[0] by the warehouse
  joint_limit,    // joint index ran into its end stop
  drive_stopped,  // drive index: no torque code came for drive_timeout; its brake closes until a code comes
  drive_resumed,  // drive index takes codes again
  drive_tripped,  // drive index: values = why (Trip), heat of its thermal model
  drive_warm,     // drive index: values = heat, above the heat at rated torque (1)
  fault,          // the sway passed 40 degrees: values = alpha, beta rad; the drives are off from here on
  joint_stuck,    // joint index came to rest and sticks (stiction)
  joint_slipped,  // joint index broke away
  collision,      // AGV index ran into something: values = closing speed m/s, the other AGV or -1
  missed,  // a touch failed and has to be repeated: index = attempts so far, values = lateral error m, yaw error rad
};

/// Why a drive tripped.
enum class Trip : std::uint8_t { overspeed, saturation, heat };
inline constexpr std::size_t trip_count = 3;

struct Event {
  Time time;
  EventKind kind;
  int index;
  std::array<double, 2> values;
};

/// "drive_tripped".
const char* name(EventKind);
/// "too hot".
const char* name(Trip);
/// The object of an event: "joint phi", "AGV 0", "container 3", "attempt 2"; empty if the event has none.
std::string object_of(const Event&, CraneKind);
/// What the two values say: "too hot, heat 1.31"; "closing speed 0.5 m/s, AGV 1"; empty if the event has none.
std::string values_of(const Event&);

}  // namespace plant
