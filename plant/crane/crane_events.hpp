#pragma once
// The crane over an interval with events: joints reach their ends, stick and break away, the rope becomes slack, the
// load swings out. The integrator finds each event as a root; the rest of the interval is integrated from there. An
// interval without a change of sign between its ends costs nothing more.
//
// Inaccuracies: a double change of sign within one interval (125 us in the dock, 1 or 10 ms in CraneAlone) is not seen.
// A joint that rests in its end stop is put back on it at each grid point, not held there by a constraint.
#include <cstdint>
#include <vector>

#include "plant/crane/crane_motion.hpp"

namespace plant {

inline constexpr double widest_sway = 40.0 * std::numbers::pi / 180.0;  // rad, beyond which the drives are switched off

struct CraneEvent {
  enum class Kind : std::uint8_t { limit, stuck, slipped, slack, swung_out } kind;
  int joint;  // or the sway coordinate, or -1
  double at;  // s after the interval's start
};

struct CraneModes {
  std::uint32_t at_limit = 0;  // joints in their end stops
  std::uint32_t stuck = 0;     // joints held by dry friction; their bits of CraneInputs::locked are set
  bool watch_rope = false;     // watch for a slack rope
};

// Advances by `seconds`. The work done in this time is added to `work`, if given.
void advance_with_events(CraneMotion&, CraneState&, CraneInputs&, CraneModes&, double seconds, std::vector<CraneEvent>&,
                         Work* work = nullptr);

// At a grid point: puts joints in or beyond an end stop back on it and stops their outward motion. Returns the joints
// (bits) that have reached one since the last call.
std::uint32_t rest_in_stops(const CraneMotion&, CraneState&, const CraneInputs&, CraneModes&);

}  // namespace plant
