#pragma once
// What a robot has reached in its work: the points by which two runs are compared.
#include <cstdint>

#include "machine/time/time.hpp"

namespace cmrc {

using machine::Time;

/// The robot of an event or a job: 0 is the crane, n is AGV n - 1.
using Robot = unsigned;

/// A step of a robot's work; milestones are in the order of time. The key identifies the same step in another run of
/// the same work.
struct Milestone {
  enum class Kind : std::uint8_t { leg_begun, point, leg_ended, ramp_begun, ramp_ended, locked, opened, process_ended };
  Robot robot = 0;
  std::uint64_t key = 0;
  Time at{};
  Kind kind() const { return static_cast<Kind>(key >> 32 & 0xF); }
};

}  // namespace cmrc
