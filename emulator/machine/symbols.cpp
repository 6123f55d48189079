#include "machine/symbols.hpp"

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "toolchain/image.hpp"

namespace machine {

namespace {

constexpr std::pair<std::string_view, std::uint32_t Symbols::*> names[] = {
    {"WINDOW_A", &Symbols::window_a},
    {"SEMAPHORE", &Symbols::semaphore},
    {"SEMAPHORE_COUNT", &Symbols::semaphore_count},
    {"SEMAPHORE_OWNER", &Symbols::semaphore_owner},
    {"SEMAPHORE_HELD", &Symbols::semaphore_held},
    {"DOORBELL_RING", &Symbols::doorbell_ring},
    {"DOORBELL_IDLE", &Symbols::doorbell_idle},
    {"DOORBELL_BUSY", &Symbols::doorbell_busy},
    {"FENCE_MASK", &Symbols::fence_mask},
    {"RESET_DSP", &Symbols::reset_dsp},
    {"LINK_ADAPTER", &Symbols::link_adapter},
    {"LINK_WORDS", &Symbols::link_words},
    {"LINK_STATUS", &Symbols::link_status},
    {"LINK_DATA", &Symbols::link_data},
    {"LINK_REQUEST", &Symbols::link_request},
    {"LINK_PORT", &Symbols::link_port},
    {"WINDOW_B", &Symbols::window_b},
    {"DRIVE_TORQUE", &Symbols::drive_torque},
    {"DRIVE_ENABLE", &Symbols::drive_enable},
    {"ENCODER", &Symbols::encoder},
    {"SWAY_ALPHA", &Symbols::sway_alpha},
    {"SWAY_BETA", &Symbols::sway_beta},
    {"SWAY2_ALPHA", &Symbols::sway2_alpha},
    {"SWAY2_BETA", &Symbols::sway2_beta},
    {"LOAD_CELL", &Symbols::load_cell},
    {"WIND_MEAN", &Symbols::wind_mean},
    {"DRIVE_STATUS", &Symbols::drive_status},
    {"DRIVE_READY", &Symbols::drive_ready},
    {"DRIVE_FAULT", &Symbols::drive_fault},
    {"DRIVE_LATE", &Symbols::drive_late},
    {"DRIVE_BRAKE", &Symbols::drive_brake},
    {"DRIVE_SPEED", &Symbols::drive_speed},
    {"DRIVE_TRIP", &Symbols::drive_trip},
    {"DRIVE_HEAT", &Symbols::drive_heat},
    {"TRIP_OVERSPEED", &Symbols::trip_overspeed},
    {"TRIP_SATURATION", &Symbols::trip_saturation},
    {"TRIP_HEAT", &Symbols::trip_heat},
    {"TRIP_WARNING", &Symbols::trip_warning},
    {"SPREADER_COMMAND", &Symbols::spreader_command},
    {"SPREADER_STATUS", &Symbols::spreader_status},
    {"SCAN_ROWS", &Symbols::scan_rows},
    {"SCAN_ROW", &Symbols::scan_row},
    {"SCAN_Y", &Symbols::scan_y},
    {"SCAN_X0", &Symbols::scan_x0},
    {"SCAN_DX", &Symbols::scan_dx},
    {"SCAN_DECK", &Symbols::scan_deck},
    {"SCAN_PROFILE", &Symbols::scan_profile},
    {"SCAN_COUNT", &Symbols::scan_count},
    {"AGV_UNIT", &Symbols::agv_unit},
    {"AGV_UNIT_WORDS", &Symbols::agv_unit_words},
    {"AGV_X", &Symbols::agv_x},
    {"AGV_Y", &Symbols::agv_y},
    {"AGV_HEADING", &Symbols::agv_heading},
    {"AGV_SPEED", &Symbols::agv_speed},
    {"AGV_STATUS", &Symbols::agv_status},
    {"AGV_PERIOD", &Symbols::agv_period},
    {"AGV_SPEED_COMMAND", &Symbols::agv_speed_command},
    {"AGV_FRONT_COMMAND", &Symbols::agv_front_command},
    {"AGV_REAR_COMMAND", &Symbols::agv_rear_command},
    {"AGV_RANGE", &Symbols::agv_range},
    {"AGV_RANGE_WORDS", &Symbols::agv_range_words},
    {"RANGE_COUNT", &Symbols::range_count},
    {"RANGE_FIRST", &Symbols::range_first},
    {"RANGE_STEP", &Symbols::range_step},
    {"RANGE_MOUNT", &Symbols::range_mount},
    {"RANGE_SCAN", &Symbols::range_scan},
    {"RANGE_WAY", &Symbols::range_way},
    {"RANGE_RAY", &Symbols::range_ray},
    {"RANGE_RAYS", &Symbols::range_rays},
    {"_start", &Symbols::start},
    {"dsp_slot", &Symbols::dsp_slot},
    {"idle_policy", &Symbols::idle_policy},
    {"pause_count", &Symbols::pause_count},
};

}  // namespace

Symbols::Symbols(const toolchain::Image& program) {
  std::string missing;
  for (const auto& [name, member] : names) {
    const auto found = program.symbols.find(name);
    if (found == program.symbols.end())
      missing.append(missing.empty() ? "" : ", ").append(name);
    else
      this->*member = found->second;
  }
  if (!missing.empty())
    throw std::invalid_argument{
        "the DSP program does not define " + missing +
        "; include task_block.inc and devices.inc, and have _start, dsp_slot, idle_policy and pause_count as labels"};
}

}  // namespace machine
