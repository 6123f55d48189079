#include "machine/system/symbols.hpp"

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "machine/bus_agents/device_registers.hpp"
#include "toolchain/objects/image.hpp"

namespace machine {

namespace {

using Name = std::pair<std::string_view, std::uint32_t Symbols::*>;
constexpr Name on_buses[] = {
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
};
constexpr Name in_memory[] = {
    {"_start", &Symbols::start},
    {"dsp_slot", &Symbols::dsp_slot},
    {"idle_policy", &Symbols::idle_policy},
    {"pause_count", &Symbols::pause_count},
};

}  // namespace

Symbols::Symbols(const toolchain::Image& program) {
  std::string missing;
  const auto look_up = [&](std::string_view name) {
    const auto found = program.symbols.find(name);
    const bool defined = found != program.symbols.end();
    if (!defined) missing.append(missing.empty() ? "" : ", ").append(name);
    return defined ? found->second : 0;
  };
  for (const auto& [name, member] : on_buses) this->*member = look_up(name);
  for (const std::string_view name : device_symbols()) look_up(name);
  for (const auto& [name, member] : in_memory) this->*member = look_up(name);
  if (!missing.empty())
    throw std::invalid_argument{
        "the DSP program does not define " + missing +
        "; include task_block.inc and devices.inc, and have _start, dsp_slot, idle_policy and pause_count as labels"};
}

}  // namespace machine
