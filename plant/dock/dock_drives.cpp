// The latch's part of the drives: codes taken, silence watched, brakes, end stops, the fault.
#include <algorithm>
#include <cmath>

#include "plant/dock/dock_core.hpp"

namespace plant {
namespace {

constexpr std::uint32_t slew_bit = 1U << static_cast<unsigned>(Joint::slew);

}  // namespace

void DockCore::take_codes() {
  protect_drives();
  if (state.underway.empty()) {
    state.code = state.shadow;
  } else {
    auto& place = state.underway[static_cast<std::size_t>(state.latch) % state.underway.size()];
    state.code = place;
    place = state.shadow;
  }
  watch_updates();
  std::uint32_t enable =
      state.faulted ? 0U : state.shadow_enable & ~state.stopped & ~state.failed_drives & ~state.protection.tripped;
  if (config.crane.machine == CraneKind::gantry) enable &= ~slew_bit;  // a gantry does not slew
  for (std::size_t j = 0; j < joint_count; ++j) {
    const bool on = bit(enable, j);
    if (on && !bit(state.enabled, j)) {
      state.inputs.braked[j] = false;
      state.inputs.locked &= ~(1U << coordinate_of(j));
      state.modes.stuck &= ~(1U << j);
    } else if (!on && bit(state.enabled, j)) {
      state.inputs.braked[j] = true;
      state.inputs.sliding[j] = 0;
      state.modes.stuck &= ~(1U << j);  // from now on the brake holds the joint instead of dry friction
    }
    const double share = 1.0 * state.code[j] / largest_torque_code;
    state.inputs.command[j] = on ? share * config.crane.drives[j].maximum_torque() : 0.0;
  }
  state.enabled = enable;
}

// A drive without new torque codes must not continue with the last one.
void DockCore::watch_updates() {
  if (config.drive_timeout <= 0.0) return;
  const auto timeout = static_cast<std::int64_t>(std::llround(config.drive_timeout / latch_seconds));
  for (std::size_t j = 0; j < joint_count; ++j) {
    const bool silent = bit(state.shadow_enable, j) && state.latch - state.updated[j] > timeout;
    if (silent == bit(state.stopped, j)) continue;
    state.stopped ^= 1U << j;
    if (silent)
      report(EventKind::drive_stopped, static_cast<int>(j));
    else if (bit(state.shadow_enable, j))
      report(EventKind::drive_resumed, static_cast<int>(j));  // else the drive was switched off
  }
}

// A closed brake slips until the joint is almost at rest and the brake can hold it, then it holds; too great a load
// makes it slip again.
void DockCore::apply_brakes() {
  CraneVector holding{};
  bool asked = false;
  const auto too_much = [this](std::size_t j, const CraneVector& force) {
    const DriveParameters& drive = config.crane.drives[j];
    return std::fabs(force[coordinate_of(j)]) > drive.brake * drive.rated_force();
  };
  // A gantry's psi is held by its construction, not by a brake that could slip.
  const std::uint32_t unbraked = config.crane.machine == CraneKind::gantry ? state.enabled | slew_bit : state.enabled;
  for (std::size_t j = 0; j < joint_count; ++j) {
    if (bit(unbraked, j)) continue;
    const std::size_t k = coordinate_of(j);
    if (!bit(state.inputs.locked, k)) {
      if (std::fabs(state.crane.qd[k]) > 1e-3 * config.crane.drives[j].rated_joint_speed()) continue;
      CraneState still = state.crane;
      CraneInputs held = state.inputs;
      crane.stop(still, held, k);
      held.braked[j] = false;
      held.locked |= 1U << k;
      if (too_much(j, crane.holding_force(still, held))) continue;
      state.crane = still;
      state.inputs = held;
      continue;
    }
    if (!asked) holding = crane.holding_force(state.crane, state.inputs);
    asked = true;
    if (too_much(j, holding)) {
      state.inputs.locked &= ~(1U << k);
      state.inputs.braked[j] = true;
    }
  }
}

void DockCore::check_limits() {
  const std::uint32_t arrived = rest_in_stops(crane, state.crane, state.inputs, state.modes);
  for (std::size_t j = 0; j < joint_count; ++j)
    if (bit(arrived, j)) report(EventKind::joint_limit, static_cast<int>(j));
}

void DockCore::check_fault() {
  const auto& q = state.crane.q;
  if (state.faulted || state.landing.active || std::max(std::fabs(q[Q_ALPHA]), std::fabs(q[Q_BETA])) < widest_sway)
    return;
  state.faulted = true;
  report(EventKind::fault, -1, q[Q_ALPHA], q[Q_BETA]);
}

}  // namespace plant
