// The latch's part of the payload: its changes between the levels, the landing's steps, twist locks, and the record of
// every change.
#include <cmath>

#include "plant/dock/dock_core.hpp"

namespace plant {
namespace {

constexpr std::int64_t clearance_latches = 8;  // how often the clearance below the payload is computed

}  // namespace

Vector3 DockCore::wind_force() const {
  if (!config.wind.blows()) return {};
  const CraneState& c = state.crane;
  const bool body = state.landing.active;
  const Vector3 velocity = body ? state.landing.body.velocity : crane.crane().payload_velocity(c.q, c.qd);
  const double yaw = body ? landing.payload_yaw(state) : c.q[Q_PSI] + c.q[Q_KAPPA];
  return wind.force(state.seconds(), velocity, yaw + state.grip.yaw, state.carried >= 0);
}

// Near contact the wind acts on the body that the landing moves.
void DockCore::blow() {
  if (!config.wind.blows() || state.landing.active) return;
  state.inputs.external = crane.crane().at_payload(state.crane.q, wind_force());
}

template <class Change>
auto DockCore::booked(EventKind kind, int container, Change change) {
  PayloadChange entry{now(), kind, container, energy(), 0.0, momentum(), {}};
  const auto result = change();
  entry.energy_after = energy();
  entry.after = momentum();
  switches.push_back(entry);
  return result;
}

// The ideal rope is valid only while it is taut and nothing is near.
void DockCore::watch_free_payload() {
  const double clearance = landing.clearance(state, crane.crane());
  if (clearance > config.landing.near) {
    const CraneVector qdd = crane.acceleration(state.crane, state.inputs);
    if (crane.crane().tension(state.crane.q, state.crane.qd, qdd, state.inputs.payload.mass) > 0.0) return;
  }
  const double jump = booked(EventKind::near_contact, state.carried, [this] { return landing.begin(state, crane); });
  report(EventKind::near_contact, -1, clearance, jump);
}

void DockCore::move_payload() {
  LandingState& near = state.landing;
  if (!near.active && state.latch % clearance_latches == 0) watch_free_payload();
  if (!near.active || state.latch < near.next) return;
  if (near.clear && state.latch % clearance_latches == 0) {
    const double clearance = landing.clearance(state, crane.crane());
    if (clearance > config.landing.away) {
      const double jump =
          booked(EventKind::free_again, state.carried, [this] { return landing.end(state, crane.crane()); });
      report(EventKind::free_again, -1, clearance, jump);
      return;
    }
  }
  const int latches = landing.latches_per_step(state, crane.crane());
  const Landing::Outcome outcome = landing.step(state, crane.crane(), wind_force(), latches * latch_seconds);
  near.next = state.latch + latches;
  near.clear = outcome.clear;
  if (outcome.touched) {
    report(EventKind::touch, -1, outcome.vertical, outcome.horizontal);
    const bool hard = outcome.vertical > config.landing.touch_speed || outcome.horizontal > config.landing.touch_sway;
    if (hard) report(EventKind::hard_landing, -1, outcome.vertical, outcome.horizontal);
    if (config.landing.strict)
      state.handover.accepted = !hard && std::fabs(landing.landing_error(state)[1]) <= config.landing.yaw_error;
  }
  if (near.corners == 0xF && near.touched && accepted() && !near.landed) {
    near.landed = true;
    report(EventKind::landed);
  } else if (near.corners == 0 && near.landed && near.contacts == 0) {
    near.landed = near.touched = false;
    report(EventKind::lifted);
  }
}

void DockCore::watch_handover(bool turned) {
  const LandingState& near = state.landing;
  HandoverView view;
  view.body = near.active;
  view.contacts = near.contacts;
  view.seated = near.corners == 0xF && accepted();
  view.turning = state.lock == Lock::locking || state.lock == Lock::opening;
  view.turned = turned;
  // The clearance is needed only once a touch has ended.
  if (state.handover.touching && near.contacts == 0) view.clearance = landing.clearance(state, crane.crane());
  if (!watch(state.handover, view)) return;
  state.landing.touched = false;  // the next touch counts as a new one
  const auto [distance, yaw] = landing.landing_error(state);
  report(EventKind::missed, state.handover.attempts, distance, yaw);
}

void DockCore::turn_locks() {
  const bool wants_lock = (state.spreader_command & 1U) != 0;
  const bool opens = !wants_lock && (state.lock == Lock::locked || state.lock == Lock::opening);
  const bool landed =
      state.landing.active && state.landing.corners == 0xF && accepted() && (!opens || landing.may_release(state));
  switch (state.lock) {
    case Lock::open:
    case Lock::locked:
      if (wants_lock == (state.lock == Lock::locked) || !landed) return;
      state.lock = wants_lock ? Lock::locking : Lock::opening;
      state.lock_done = state.latch + std::llround(config.landing.lock_time / latch_seconds);
      return;
    case Lock::locking:
    case Lock::opening: break;
  }
  const bool locking = state.lock == Lock::locking;
  if (!landed || wants_lock != locking) {
    state.lock = locking ? Lock::open : Lock::locked;
    report(EventKind::refused);
    return;
  }
  if (state.latch < state.lock_done || state.latch < state.landing.next) return;
  if (locking) {
    state.lock = Lock::locked;
    const int taken = booked(EventKind::locked, state.carried, [this] { return landing.take(state); });
    switches.back().container = taken;
    report(EventKind::locked, taken);
    watch_handover(true);
    return;
  }
  state.lock = Lock::open;
  const int container = booked(EventKind::opened, state.carried, [this] { return landing.release(state); });
  watch_handover(true);
  report(EventKind::opened, container);
  if (container >= 0 && state.containers[static_cast<std::size_t>(container)].state == ContainerState::on_agv)
    report(EventKind::set_on_agv, container, state.containers[static_cast<std::size_t>(container)].agv);
}

}  // namespace plant
