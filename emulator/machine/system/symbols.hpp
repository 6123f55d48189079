#pragma once
// The constants shared by DSP programs and the machine, read from the assembled program
// (c40_programs/include/task_block.inc, devices.inc).
#include <cstdint>

namespace toolchain {
struct Image;
}

namespace machine {

struct Symbols {
  /// Throws std::invalid_argument with the names of all constants that the program does not define, including those of
  /// the devices.
  explicit Symbols(const toolchain::Image& program);

  // bus A
  std::uint32_t window_a, semaphore, semaphore_count, semaphore_owner, semaphore_held, doorbell_ring, doorbell_idle,
      doorbell_busy, fence_mask, reset_dsp, link_adapter, link_words, link_status, link_data, link_request, link_port;
  // bus B; machine/bus_agents/device_registers.hpp has its registers
  std::uint32_t window_b;
  // addresses in the DSP's own memory
  std::uint32_t start, dsp_slot, idle_policy, pause_count;
};

}  // namespace machine
