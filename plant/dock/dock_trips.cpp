// The drives' own protection: why a drive trips, and when the trip ends.
#include <algorithm>
#include <cmath>

#include "plant/dock/dock_core.hpp"

namespace plant {
namespace {

constexpr std::uint32_t bit_of(Trip cause) { return 1U << static_cast<unsigned>(cause); }
static_assert(bit_of(Trip::overspeed) == trip_overspeed && bit_of(Trip::saturation) == trip_saturation &&
              bit_of(Trip::heat) == trip_heat);

std::int64_t latches(double seconds) { return std::llround(seconds / latch_seconds); }

}  // namespace

// For the interval that has ended: its codes were held, and its heat is that of the torque at its end. A trip lasts
// until the drive is switched off; a trip by the thermal model also until the motor has cooled to the heat that it
// withstands permanently.
void DockCore::protect_drives() {
  ProtectionState& p = state.protection;
  const std::uint32_t switched_on = state.shadow_enable & ~p.asked;
  p.asked = state.shadow_enable;
  for (std::uint32_t& cause : p.causes) cause &= ~switched_on | p.tripped;
  for (std::size_t j = 0; j < joint_count; ++j) {
    const DriveParameters& drive = config.crane.drives[j];
    const bool on = bit(state.enabled, j);
    const double load = state.crane.torque[j] / drive.rated_torque;
    p.heat[j] += latch_seconds / drive.thermal_time * (load * load - p.heat[j]);
    const bool fast = on && std::fabs(state.crane.qd[coordinate_of(j)]) > drive.overspeed * drive.rated_joint_speed();
    p.fast[j] = fast ? p.fast[j] + 1 : 0;
    p.saturated[j] = on && std::abs(state.code[j]) >= largest_torque_code ? p.saturated[j] + 1 : 0;
    const bool hunts = count_swings(j, on);
    if ((p.heat[j] > 1.0) != bit(p.warm, j)) {
      p.warm ^= 1U << j;
      if (bit(p.warm, j)) report(EventKind::drive_warm, static_cast<int>(j), p.heat[j]);
    }
    if (p.fast[j] > 0 && p.fast[j] >= latches(drive.overspeed_time)) trip(j, Trip::overspeed);
    if (hunts || (p.saturated[j] > 0 && p.saturated[j] >= latches(drive.saturation_time))) trip(j, Trip::saturation);
    if (on && p.heat[j] > drive.thermal_trip) trip(j, Trip::heat);
    const bool too_hot = bit(p.causes[static_cast<std::size_t>(Trip::heat)], j) && p.heat[j] > 1.0;
    if (bit(p.tripped, j) && !bit(state.shadow_enable, j) && !too_hot) p.tripped &= ~(1U << j);
  }
}

// An unstable loop swings the code from one end of its range to the other, mostly in less than saturation_time.
bool DockCore::count_swings(std::size_t joint, bool on) {
  ProtectionState& p = state.protection;
  const DriveParameters& drive = config.crane.drives[joint];
  const int code = state.code[joint];
  if (!on) {
    p.swings[joint] = p.end[joint] = 0;
    return false;
  }
  ++p.since_swing[joint];
  if (p.swings[joint] != 0 && p.since_swing[joint] > latches(drive.saturation_time)) p.swings[joint] = 0;
  const int end = std::abs(code) < largest_torque_code ? 0 : code > 0 ? 1 : -1;
  if (end == 0 || end == p.end[joint]) return false;
  if (p.end[joint] != 0) {
    ++p.swings[joint];
    p.since_swing[joint] = 0;
  }
  p.end[joint] = end;
  return p.swings[joint] >= drive.saturation_swings;
}

void DockCore::trip(std::size_t joint, Trip cause) {
  ProtectionState& p = state.protection;
  p.fast[joint] = p.saturated[joint] = 0;
  p.swings[joint] = p.end[joint] = 0;
  p.tripped |= 1U << joint;
  p.causes[static_cast<std::size_t>(cause)] |= 1U << joint;
  report(EventKind::drive_tripped, static_cast<int>(joint), static_cast<double>(cause), p.heat[joint]);
}

std::uint32_t DockCore::drive_trip(std::size_t joint) const {
  const ProtectionState& p = state.protection;
  std::uint32_t said = bit(p.warm, joint) ? trip_warning : 0U;
  for (std::size_t cause = 0; cause < trip_count; ++cause)
    if (bit(p.causes[cause], joint)) said |= 1U << cause;
  return said;
}

std::int32_t DockCore::drive_heat(std::size_t joint) const {
  return static_cast<std::int32_t>(std::floor(std::min(state.protection.heat[joint], 10.0) * rated_units + 0.5));
}

}  // namespace plant
