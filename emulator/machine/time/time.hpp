#pragma once
// The machine's time is the time of its chips (c40/values/clock.hpp).
#include <limits>

#include "c40/values/clock.hpp"
#include "c40/values/types.hpp"

namespace machine {

using c40::Clock;
using c40::never;
using c40::PacedClock;
using c40::Skew;
using c40::Ticks;
using c40::Time;

/// Later than every cycle.
inline constexpr c40::Cycles never_cycle = std::numeric_limits<c40::Cycles>::max();

}  // namespace machine
