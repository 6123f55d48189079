#pragma once
// The constants that DSP programs and the machine share, taken from the assembled program
// (c40_programs/include/task_block.inc, devices.inc).
#include <cstdint>

namespace toolchain {
struct Image;
}

namespace machine {

struct Symbols {
  /// Throws std::invalid_argument with the names of all that the program does not define.
  explicit Symbols(const toolchain::Image& program);

  // bus A
  std::uint32_t window_a, semaphore, semaphore_count, semaphore_owner, semaphore_held, doorbell_ring, doorbell_idle,
      doorbell_busy, fence_mask, reset_dsp, link_adapter, link_words, link_status, link_data, link_request, link_port;
  // bus B
  std::uint32_t window_b, drive_torque, drive_enable, encoder, sway_alpha, sway_beta, sway2_alpha, sway2_beta, load_cell, wind_mean, spreader_command, spreader_status;
  std::uint32_t drive_status, drive_ready, drive_fault, drive_late, drive_brake, drive_speed, drive_trip, drive_heat, trip_overspeed, trip_saturation, trip_heat, trip_warning;
  std::uint32_t scan_rows, scan_row, scan_y, scan_x0, scan_dx, scan_deck, scan_profile, scan_count;
  std::uint32_t agv_unit, agv_unit_words, agv_x, agv_y, agv_heading, agv_speed, agv_status, agv_period,
      agv_speed_command, agv_front_command, agv_rear_command;
  std::uint32_t agv_range, agv_range_words, range_count, range_first, range_step, range_mount, range_scan, range_way, range_ray, range_rays;
  // addresses in the DSP's own memory
  std::uint32_t start, dsp_slot, idle_policy, pause_count;
};

}  // namespace machine
