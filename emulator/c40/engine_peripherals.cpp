// Accesses to communication ports, the entry into interrupts, and the reset vector.
#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "c40/choices.hpp"
#include "c40/engine.hpp"
#include "c40/interrupts.hpp"

namespace c40 {

// What the access finds. One that a link is concerned with, or that has to wait, stops the chip first.
Engine::Stepped Engine::access_port(const Step& step, std::size_t k, Word& cell) {
  const Core& core = state_.core;
  const Answer& answer = state_.answers[k];
  const bool write = core.miss_write;
  if (!answer.given || answer.address != core.miss_address || answer.write != write) {
    access_.begin(k, port_access(core.miss_address, write, write ? core.miss_value : 0, access_cycle(step, k)));
    if (!ports_.is_free(access_.port())) return Stepped::port;
    complete_port(access_.cycle());
  }
  cell = answer.value;
  return Stepped::done;
}

void Engine::complete_port(Cycles at) {
  if (!access_.at_port()) throw std::logic_error("the chip waits for no communication port");
  const PortAccess& access = access_.port();
  CommPort& side = ports_[access.port];
  if (!access.ready(side))
    throw std::logic_error(fmt::format("communication port {}: the {} FIFO is {}", access.port, access.write ? "output" : "input",
                                       access.write ? "full" : "empty"));
  if (at < access.cycle) throw std::logic_error("an access cannot take place before it begins");
  peripherals_.end_dma_block(at);
  peripherals_.advance_to(at);
  const Word value = access.perform(side);
  access_.answer_port(value, at);
  ports_.accessed(access, value, at, -1);
}

// ---- interrupts ----

bool Engine::take_interrupt(Word vector) {
  Core& core = state_.core;
  const Address top = core.r[reg::SP] + 1, entry = (core.ivtp & choices::vector_table_mask) + vector;
  const Memory::Area* stack = memory_.find(top);
  const Memory::Area* table = memory_.find(entry);
  for (const auto& [area, address, what] : {std::tuple{stack, top, "the stack"}, std::tuple{table, entry, "the vector table"}})
    if (area == nullptr || area->data == nullptr) {
      fail(Fault::Kind::not_modelled, fmt::format("interrupt {:02X}h: {} at {:08X}h is not in RAM", vector, what, address), address);
      return false;
    }
  const Cycles before = state_.cycle;
  poke(top, core.pc);
  core.r[reg::SP] = top;
  core.pc = table->data[entry - table->base];
  interrupts::enter(core, vector);
  const int waits = memory_.meet(*table, entry, false, state_.open_pages).access.waits + memory_.meet(*stack, top, true, state_.open_pages).access.waits;
  add(state_.causes, Cause::interrupt, timing::interrupt_entry_cost);
  add(state_.causes, Cause::wait_state, waits);
  state_.cycle += timing::interrupt_entry_cost + waits;
  onward_.clear();
  pipeline_.release().flush(timing::interrupt_entry_cost + waits);
  dma_side_.flushed(timing::interrupt_entry_cost + waits);
  if (peripherals_.dma_active()) dma_side_.mark_under_way();
  cache_.note_control(before);
  if (trace != nullptr) trace->interrupt(vector, before);
  tell({PeripheralEvent::Kind::interrupt, before, static_cast<int>(vector), peek(top)});
  return true;
}

Word Engine::watched_ports() const {
  if (ports_.attached() == 0) return 0;
  const Word enabled = state_.core.r[reg::IIE] & interrupts::port_sources;
  Word watched = 0;
  for (unsigned n = 0; enabled >> 4 * n != 0; ++n)
    if (interrupts::port_enables(enabled, n) != 0) watched |= 1u << n;
  if (peripherals_.dma_active()) watched |= dma_.ports_used();
  return watched & ports_.attached();
}

// The reset vector is an address, at a place that two pins choose (c40-hardware.md 1.2).
void Engine::boot() {
  constexpr std::array<Address, 4> vectors{0x00000000u, 0x7FFFFFFFu, 0x80000000u, 0xFFFFFFFFu};
  constexpr Word interface_after_reset = 0x3E39FFF0u;
  reset();
  const Address vector = vectors.at(static_cast<std::size_t>(board_.pins.reset_location));
  try {
    state_.core.pc = peek(vector);
  } catch (const std::out_of_range&) {
    throw std::out_of_range(fmt::format("the reset vector of RESETLOC {} stands at {:08X}h, where board {} has no memory{}",
                                        board_.pins.reset_location, vector, board_.name,
                                        vector == 0 && board_.rom.empty() ? " and no boot ROM" : ""));
  }
  if (!board_.has_peripherals) return;
  poke(Peripherals::global_interface, interface_after_reset);
  poke(Peripherals::local_interface, interface_after_reset);
}

}  // namespace c40
