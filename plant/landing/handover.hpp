#pragma once
// How a container changes hands (plant-and-bus.md 1.5): FREE, ALIGN, LANDED, LOCK, TENSION, LIFT, with an empty
// spreader to take one, with a container below it to set it down. A landing that does not come to four closed corners
// is a missed attempt, and the next touch a retry.
#include <array>
#include <cstdint>

#include "plant/dock/dock.hpp"

namespace plant {

struct HandoverState {
  HandoverPhase phase = HandoverPhase::free;
  int attempts = 0;       // touches since the payload last hung free
  bool touching = false;  // an attempt is on
  bool accepted = false;  // the touch was within the tolerances (only asked for by LandingParameters::strict)
};

// What the machine sees after a step of the landing.
struct HandoverView {
  bool body = false;  // level L2
  int contacts = 0;
  double clearance = 0.0;  // m
  bool seated = false;     // all four corners closed
  bool turning = false;    // twist locks on their way
  bool turned = false;     // they have just finished
};

// Moves on; true if an attempt was missed just now.
bool watch(HandoverState&, const HandoverView&);

}  // namespace plant
