#pragma once
// What everyone needs who knows of the dock: its time, the crane's joints, the kinds of cranes.
#include <array>
#include <chrono>
#include <cstdint>

namespace plant {

using Time = std::chrono::duration<std::int64_t, std::pico>;
inline constexpr Time latch_period{125'000'000};  // 8 kHz
inline constexpr double latch_seconds = 125e-6;
inline constexpr std::int64_t agv_latches = 8;    // AGVs move on a 1-ms grid
inline constexpr std::int64_t tick_latches = 80;  // 100 Hz: AGV drives, sway sensor

inline constexpr int joint_count =
    5;  // actuated: s gantry [m], psi slew, phi luff [rad], l hoist [m], kappa rotator [rad]
inline constexpr double gravity = 9.81;  // m/s2

enum class Joint : std::uint8_t { gantry, slew, luff, hoist, rotator };

using Joints = std::array<double, joint_count>;

// The kind of crane. The ship-to-shore gantry does not slew (its psi is held at pi/2, across the quay), and its
// coordinate phi is the trolley's place on the boom, m from the crane's rail: its jib is a trolley of jib_mass at this
// place, on a boom at pivot_height.
enum class CraneKind : std::uint8_t { slewing, gantry };

}  // namespace plant
