// Drive status and speed, load cell, second sway sensor, anemometer: their values, and the values that they keep after
// a failure.
#include <algorithm>
#include <cmath>

#include "plant/dock/dock_core.hpp"
#include "plant/dock/sensors.hpp"

namespace plant {
namespace {

constexpr double wind_window = 3.0;  // s, of the anemometer's mean

std::int32_t in_steps(double value, double step) { return static_cast<std::int32_t>(std::floor(value / step) * step); }

}  // namespace

std::uint32_t DockCore::drive_status(std::size_t joint) const {
  const InstrumentState& seen = state.instruments;
  if (bit(seen.stuck_status, joint)) return seen.held_status[joint];
  const bool fault = state.faulted || bit(state.failed_drives, joint) || bit(state.protection.tripped, joint);
  const bool late = bit(state.stopped, joint);
  return (fault || late ? 0U : drive_ready) | (fault ? drive_fault : 0U) | (late ? drive_late : 0U) |
         (bit(state.enabled, joint) ? 0U : drive_brake);
}

std::int32_t DockCore::drive_speed(std::size_t joint) const {
  const InstrumentState& seen = state.instruments;
  if (bit(seen.stuck_speeds, joint)) return seen.held_speed[joint];
  const double share = state.crane.qd[coordinate_of(joint)] / config.crane.drives[joint].rated_joint_speed();
  return static_cast<std::int32_t>(std::floor(std::clamp(share, -3.0, 3.0) * rated_units + 0.5));
}

std::int32_t DockCore::wind_mean(double seconds) const {
  if (state.instruments.stuck_wind) return state.instruments.held_wind;
  return static_cast<std::int32_t>(std::floor(1e3 * wind.mean(seconds - wind_window, seconds) + 0.5));
}

// Uses the sway sensor's clock: a value sampled now can be read one sample later.
void DockCore::sample_instruments(std::int64_t sample) {
  InstrumentState& seen = state.instruments;
  const auto angles = sway();
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (bit(seen.stuck_sways, axis)) continue;
    seen.sway_shown[axis] = seen.sway_sampled[axis];
    seen.sway_sampled[axis] = sway_code(
        angles[axis], config.sensors, axis == 0 ? Stream::second_sway_radial : Stream::second_sway_tangential, sample);
  }
  if (seen.stuck_load) return;
  seen.load_shown = seen.load_sampled;
  seen.load_sampled = in_steps(tension() / gravity, load_step);
}

}  // namespace plant
