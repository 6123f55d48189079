#pragma once
// The hand-over of a container (plant-and-bus.md 1.5): FREE, ALIGN, LANDED, LOCK, TENSION, LIFT; an empty spreader
// takes a container, a loaded one sets it down. A landing without four closed corners is a missed attempt, and the next
// touch a retry.

#include "plant/dock/dock_values.hpp"

namespace plant {

struct HandoverState {
  HandoverPhase phase = HandoverPhase::free;
  int attempts = 0;       // touches since the payload last hung free
  bool touching = false;  // an attempt is under way
  bool accepted = false;  // the touch was within the tolerances (only needed with LandingParameters::strict)
};

// What the state machine sees after a step of the landing.
struct HandoverView {
  bool body = false;  // level L2
  int contacts = 0;
  double clearance = 0.0;  // m
  bool seated = false;     // all four corners closed
  bool turning = false;    // twist locks are turning
  bool turned = false;     // they have just finished turning
};

// Advances; true if an attempt was missed just now.
bool watch(HandoverState&, const HandoverView&);

}  // namespace plant
