#pragma once
// The same run with instant execution: what missed deadlines and delays cost is the difference (docs/report.md, Ideal).
//
// It runs the same programs on the same bits, so that its arithmetic is the controller's own; only time is taken away:
// DSPs and buses are ideal_speed times as fast, and the host works in no time. Every block ends within microseconds of
// its release, well before the next latch of the drives. What fails in the machine does not fail here; the operator's
// changes, drives and sensors do as asked.
#include <cstdint>

#include "cmrc/configuration/config.hpp"

namespace cmrc {

inline constexpr std::int64_t ideal_speed = 1000;

/// The configuration that a run with run.ideal has: as given where it is not set.
Config as_run(const Config& config);

/// The same run, ideal.
Config ideal(Config config);

}  // namespace cmrc
