#pragma once
// The dock's whole state: a value that is not here does not affect the future. Plain values only.
#include <array>
#include <cstdint>
#include <vector>

#include "plant/crane/crane_events.hpp"
#include "plant/dock/dock_event.hpp"
#include "plant/landing/contact.hpp"
#include "plant/landing/handover.hpp"
#include "plant/parameters/device_codes.hpp"
#include "plant/scene/scene.hpp"
#include "plant/vehicles/agv.hpp"

namespace plant {

enum class Lock : std::uint8_t { open, locking, locked, opening };

// The container under the spreader: its centre and heading in the spreader's frame, and its top's height above the
// spreader's underside.
struct Grip {
  double x = 0.0, y = 0.0, yaw = 0.0, top = 0.0;
};

// The payload near contact: a body of its own (level L2).
struct LandingState {
  bool active = false;
  BodyState body{};
  double slack = 0.0;     // m, by which the unstretched falls are shorter than q_l
  std::int64_t next = 0;  // latch at which the body's step ends
  bool touched = false;   // since it was last clear
  int contacts = 0;
  bool clear = false;    // the last step was free of contact with all falls taut
  double tension = 0.0;  // N, sum of the falls
  unsigned corners = 0;  // switches, bit i
  bool landed = false;   // all four closed, until all four open
};

// Instruments other than encoders and the first sway sensor (plant/dock/dock_instruments.cpp). `stuck_...`: a failed
// one keeps `held_...`.
struct InstrumentState {
  std::array<std::int32_t, 2> sway_shown{}, sway_sampled{};  // the second sway sensor, like the first
  std::int32_t load_shown = 0, load_sampled = 0;             // load cell, kg
  std::uint32_t stuck_status = 0, stuck_speeds = 0;          // by joint
  std::uint32_t stuck_sways = 0;                             // by axis, of the second sensor
  bool stuck_load = false, stuck_wind = false;
  std::array<std::uint32_t, joint_count> held_status{};
  std::array<std::int32_t, joint_count> held_speed{};
  std::int32_t held_wind = 0;
};

// The drives' own protection (plant/dock/dock_trips.cpp).
struct ProtectionState {
  std::array<std::int64_t, joint_count> fast{},
      saturated{};                     // latches for which the drive has been too fast, or at its largest code
  std::array<int, joint_count> end{};  // end of the code's range at which the code was last: 1, -1, or 0
  std::array<std::int64_t, joint_count> since_swing{};  // latches since its last swing from one end to the other
  std::array<int, joint_count> swings{};   // number of such swings, each within saturation_time of the one before
  std::array<double, joint_count> heat{};  // of the thermal model: 1 is the heat at rated torque
  std::array<std::uint32_t, trip_count> causes{};  // by joint, of the last trip; until the drive is switched on again
  std::uint32_t tripped = 0;                       // until it is switched off, and has cooled to 1
  std::uint32_t warm = 0;                          // heat above 1
  std::uint32_t asked = 0;                         // shadow_enable at the last latch
};

struct DockState {
  std::int64_t latch = 0;  // number of the last latch; its time is latch * 125 us
  CraneState crane;
  CraneInputs inputs;                             // held since that latch
  double stretch = 0.0;                           // m: rope below the tip minus the rope that the drum has paid out
  std::array<int, joint_count> shadow{}, code{};  // torque codes: written, and taken at the latch
  std::vector<std::array<int, joint_count>> underway;  // codes under way to the drives, by latch modulo drive_delay
  std::uint32_t shadow_enable = 0, enabled = 0;
  std::array<std::int64_t, joint_count> updated{};  // last latch before the code was written, or first switched on
  std::uint32_t stopped = 0;                        // drives that have had no code for drive_timeout
  std::uint32_t failed_drives = 0;
  ProtectionState protection;
  std::uint32_t stuck_encoders = 0, stuck_sways = 0;
  std::array<std::int64_t, joint_count> stuck_count{};  // the value of a stuck encoder
  std::uint32_t spreader_command = 0;
  Lock lock = Lock::open;
  std::int64_t lock_done = 0;  // latch at which the twist locks finish turning
  int carried = -1;            // container
  Grip grip;
  LandingState landing;
  HandoverState handover;
  std::array<std::int32_t, 2> sway_shown{}, sway_sampled{};  // codes: readable now, and 10 ms later
  InstrumentState instruments;
  std::vector<ContainerData> containers;
  std::vector<AgvState> agvs;
  std::vector<std::array<std::int32_t, range_rays>> scans;  // per AGV, if the range sensors have their own rate
  int row = 0;                                              // of the bay scanner
  CraneModes modes;                                         // of the crane's joints
  bool faulted = false;
  int delivered = 0;

  double seconds() const { return static_cast<double>(latch) * latch_seconds; }
};

}  // namespace plant
