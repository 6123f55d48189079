#include "plant/landing/handover.hpp"

namespace plant {
namespace {

constexpr double attempt_over = 0.1;  // m, clearance at which a failed touch has ended

HandoverPhase next(HandoverPhase phase, const HandoverView& now) {
  if (!now.body) return HandoverPhase::free;
  switch (phase) {
    case HandoverPhase::free: return HandoverPhase::align;
    case HandoverPhase::align: return now.seated ? HandoverPhase::landed : phase;
    case HandoverPhase::landed:
      if (now.turning) return HandoverPhase::lock;
      return now.contacts == 0 && !now.seated ? HandoverPhase::align : phase;
    case HandoverPhase::lock:
      if (now.turned) return HandoverPhase::tension;
      return now.turning ? phase : HandoverPhase::landed;
    case HandoverPhase::tension: return now.contacts == 0 && !now.seated ? HandoverPhase::lift : phase;
    case HandoverPhase::lift: return now.contacts > 0 ? HandoverPhase::align : phase;
  }
  return phase;
}

}  // namespace

bool watch(HandoverState& s, const HandoverView& now) {
  const bool again = s.phase == HandoverPhase::tension || s.phase == HandoverPhase::lift;
  s.phase = next(s.phase, now);
  if (s.phase == HandoverPhase::free) {
    s = {};
    return false;
  }
  if (!s.touching && now.contacts > 0 && !again) {
    s.touching = true;
    ++s.attempts;
  }
  if (!s.touching || now.contacts > 0 || now.clearance < attempt_over) return false;
  s.touching = false;
  s.accepted = false;
  return s.phase == HandoverPhase::align;
}

}  // namespace plant
