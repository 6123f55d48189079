#include "c40/chip/snapshot.hpp"

#include "c40/chip/state.hpp"
#include "c40/memory/memory.hpp"
#include "c40/peripherals/register_map.hpp"
#include "isa/types.hpp"

namespace c40 {

std::uint64_t digest(const Memory& memory) {
  std::uint64_t sum = 0;
  for (const auto& area : memory.areas()) {
    if (area->data == nullptr) continue;
    for (Word i = 0; i < area->words; ++i)
      if (const Word word = area->data[i]; word != 0) {
        std::uint64_t h = (std::uint64_t{area->base + i} << 32 | word) * 0x9E3779B97F4A7C15u;
        sum += (h ^ h >> 29) * 0xBF58476D1CE4E5B9u;
      }
  }
  return sum;
}

std::vector<std::uint64_t> snapshot(const Chip& chip) {
  std::vector<std::uint64_t> out;
  const State& state = chip.state();
  for (std::uint8_t code = 0; code < isa::register_count; ++code)
    out.push_back(chip.register_value(static_cast<isa::Register>(code)));
  out.insert(out.end(), {state.core.ivtp, state.core.tvtp, chip.pc(), static_cast<std::uint64_t>(chip.cycle()),
                         chip.instructions(), state.core.idle, state.core.delay_slots, state.core.repeat_single,
                         state.locked[0], state.locked[1]});
  for (const Cycles cycles : chip.causes()) out.push_back(static_cast<std::uint64_t>(cycles));
  for (const RegisterInfo& info : register_map()) {
    const bool fifo =
        is_port_register(info.address) && port_access(info.address, false, 0, 0).reg != PortRegister::control;
    if (!fifo) out.push_back(chip.peek(info.address));
  }
  for (const CommPort& port : state.ports)
    for (const Fifo* fifo : {&port.input, &port.output})
      out.insert(out.end(), fifo->words().begin(), fifo->words().end());
  state.cache.each_word(
      [&](Address address) { out.push_back(std::uint64_t{address} << 32 | *state.cache.find(address)); });
  return out;
}

}  // namespace c40
