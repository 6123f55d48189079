// The settings of --preset; docs/configuration.md, Presets, gives the reasons.
#include "cmrc/configuration/config.hpp"

namespace cmrc {

std::span<const Preset> presets() {
  static constexpr Preset all[] = {
      {"base", "f_s 8 kHz, f_p 1 kHz, f_t 125 Hz, f_a 50 Hz, one AGV: the defaults", ""},
      {"heavy",
       "f_s 16 kHz, f_p 2 kHz, 4 AGVs that drive from the start, obstacle avoidance by the dynamic window for each AGV "
       "and point",
       R"(
[rates]
refresh_frequency_hz = 16000
servo_frequency_hz = 2000
[scheduling]
alpha_refreshes = 48
beta_refreshes = 24
a = 0x20
agv_interval_max_refreshes = 640
[kernels]
avoidance = "dynamic_window"
[load]
driving = true
[dock]
agvs = 4
)"},
      {"saturated",
       "base rates, 4 AGVs that drive from the start, and a synthetic avoidance block of 330 000 cycles (13.2 ms) per "
       "AGV and point",
       R"(
[load]
avoidance_cycles = 330000
driving = true
[dock]
agvs = 4
)"},
      {"tight",
       "base rates, and loops of 80 rad/s (slew, luff, hoist, rotator, trolley): they allow a delay of only 3.5 ms",
       R"(
[control]
slew_bandwidth_rad_s = 80
luff_bandwidth_rad_s = 80
trolley_bandwidth_rad_s = 80
hoist_bandwidth_rad_s = 80
rotator_bandwidth_rad_s = 80
)"},
  };
  return all;
}

}  // namespace cmrc
