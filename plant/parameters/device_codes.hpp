#pragma once
// The words of the dock's devices: sizes, bits and units.
#include <cstdint>

namespace plant {

// ---- encoders and drives
inline constexpr int encoder_bits = 24;
inline constexpr double counts_per_revolution = 16384.0;
inline constexpr int torque_bits = 12;                                    // signed
inline constexpr int largest_torque_code = (1 << (torque_bits - 1)) - 1;  // the drive's maximum_torque()
inline constexpr double rated_units = 10'000.0;                           // rated speed, and the heat at rated torque
// Bits of a drive's status.
inline constexpr std::uint32_t drive_ready = 1, drive_fault = 2, drive_late = 4, drive_brake = 8;
// Bits of a drive's report on its own protection: why it has tripped, in the order of Trip, and a warning.
inline constexpr std::uint32_t trip_overspeed = 1, trip_saturation = 2, trip_heat = 4, trip_warning = 8;

// ---- sway, load, spreader
inline constexpr int sway_bits = 12;                     // signed
inline constexpr int sway_codes = 1 << (sway_bits - 1);  // to either side; so many are SensorParameters::sway_range
inline constexpr double load_step = 10.0;                // kg
// Bits of the spreader's status: a switch for each corner, the twist locks.
inline constexpr std::uint32_t spreader_corners = 0x0F, spreader_locked = 0x10, spreader_open = 0x20;

// ---- bay scanner
inline constexpr int scan_count = 128;  // samples of a row
inline constexpr int scan_quantum = 8;  // mm

// ---- AGV units
inline constexpr int agv_queue = 4;  // set-points
// Bits of a unit's status; the lowest are the number of set-points that wait.
inline constexpr std::uint32_t agv_waiting = 0x0F, agv_standing = 0x10, agv_loaded = 0x20, agv_ran_dry = 0x40,
                               agv_bumper = 0x80;

// ---- their range sensors
inline constexpr int range_rays = 180;
// Microradians from the heading, left positive: -89.5 degrees, 1 degree.
inline constexpr std::int32_t range_first = -1'562'070, range_step = 17'453;
inline constexpr std::int32_t range_most = 30'000, range_least = 50, range_quantum = 8;  // mm

}  // namespace plant
