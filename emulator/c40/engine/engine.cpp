#include "c40/engine/engine.hpp"

#include <fmt/format.h>

#include <limits>
#include <stdexcept>
#include <utility>

namespace c40 {

Engine::Engine(Board board)
    : board_(std::move(board)),
      memory_(board_),
      dma_(state_.dma, dma_side_),
      dma_side_({state_, memory_, ports_, peripherals_, cache_, pipelines_, pipeline_, dma_, tell, probe_,
                 [this](Address address, Word value) { poke(address, value); }}) {
  reset();
}

void Engine::reset() {
  pipeline_.forget();
  flush_blocks();
  ports_.about_to_reset(state_.cycle);
  const State old = state_;
  state_ = State{};
  state_.cycle = old.cycle;
  state_.instructions = old.instructions;
  state_.causes = old.causes;
  state_.held = old.held;
  state_.iiof_levels = old.iiof_levels;
  state_.iiof_driven = old.iiof_driven;
  state_.nmi_low = old.nmi_low;
  state_.drives = old.drives;
  for (std::size_t n = 0; n < timer_count; ++n) state_.timers[n].restart(old.timers[n]);
  state_.ports = old.ports;
  ports_.reset(state_.cycle);
  state_.dma.now = state_.cycle;
  dma_side_.reset();
  peripherals_.was_reset();
  state_.core.e.fill(float40::zero_exponent);
  state_.global_interface_control = board_.global_interface_control;
  state_.local_interface_control = board_.local_interface_control;
  pins_.show_inputs();
  if (state_.nmi_low) state_.core.r[reg::IIF] |= interrupts::nmi_flag;  // c40-hardware.md 1.2
  peripherals_.pins_changed();
  cache_.was_reset();
  forget_memory();
  fault_.reset();
  access_.forget();
  reported_breakpoint_.reset();
  touch();
}

// The address of the reset vector is one of four places, chosen by two pins (c40-hardware.md 1.2).
void Engine::boot() {
  constexpr std::array<Address, 4> vectors{0x00000000u, 0x7FFFFFFFu, 0x80000000u, 0xFFFFFFFFu};
  constexpr Word interface_after_reset = 0x3E39FFF0u;
  reset();
  const Address vector = vectors.at(static_cast<std::size_t>(board_.pins.reset_location));
  try {
    state_.core.pc = peek(vector);
  } catch (const std::out_of_range&) {
    throw std::out_of_range(fmt::format("the reset vector of RESETLOC {} is at {:08X}h, where board {} has no memory{}",
                                        board_.pins.reset_location, vector, board_.name,
                                        vector == 0 && board_.rom.empty() ? " and no boot ROM" : ""));
  }
  if (!board_.has_peripherals) return;
  poke(Peripherals::global_interface, interface_after_reset);
  poke(Peripherals::local_interface, interface_after_reset);
}

State& Engine::touch() {
  dma_side_.forget_undisturbed();
  onward_.clear();
  pipeline_.release();
  return state_;
}

void Engine::flush_blocks() {
  settle_counts();
  blocks_.clear(memory_);
  exact_addresses_.clear();
  onward_.clear();
  cache_.blocks_cleared(memory_);
}

// All knowledge about memory was found with the old values of the interface control registers.
void Engine::forget_memory() {
  memory_.configure(state_.global_interface_control, state_.local_interface_control);
  code_ = {};
  decoded_slots_.forget();
}

void Engine::set_probe(Probe* probe, ProbePlan plan) {
  flush_blocks();
  memory_.set_apart(plan.data);
  probe_.set(probe, std::move(plan));
  forget_memory();
  cache_.blocks_cleared(memory_);
}

// Pipeline states get new ids.
void Engine::forget_pipelines() {
  flush_blocks();
  touch();
  pipelines_.clear();
  decoded_slots_.forget_transitions();
}

void Engine::settle_counts() {
  blocks_.settle(state_.causes, state_.instructions);
  pipeline_.settle();
  cache_.settle();
}

Word Engine::peek(Address address) const {
  const Memory::Area* area = memory_.find(address);
  if (area == nullptr && board_.is_flat) return 0;
  if (area == nullptr)
    throw std::out_of_range(fmt::format("address {:08X}h is reserved on board {}", address, board_.name));
  if (area->data != nullptr) return area->data[address - area->base];
  Word value = 0;
  if (area->kind == Region::Kind::registers && peripherals_.read(address, state_.cycle, value)) return value;
  throw std::out_of_range(fmt::format("address {:08X}h ({}) cannot be read without a bus access", address, area->name));
}

void Engine::poke(Address address, Word value) {
  const Memory::Area* area = memory_.find(address);
  if (area == nullptr && board_.is_flat)
    throw std::out_of_range(fmt::format("address {:08X}h: more than the {} MiB of RAM that board {} may take", address,
                                        board_.flat_words_max * sizeof(Word) >> 20, board_.name));
  if (area == nullptr)
    throw std::out_of_range(fmt::format("address {:08X}h is reserved on board {}", address, board_.name));
  if (area->data == nullptr) {
    peripherals_.give_all_dma_inputs();
    if (area->kind == Region::Kind::registers && peripherals_.write(address, value, state_.cycle)) return;
    throw std::out_of_range(
        fmt::format("address {:08X}h ({}) cannot be written without a bus access", address, area->name));
  }
  const Word offset = address - area->base;
  if ((area->code_map()[offset >> 5] >> (offset & 31) & 1u) != 0) {
    cache_.memory_written(address);
    flush_blocks();
  }
  area->data[offset] = value;
}

void Engine::process_code_writes() {
  Core& core = state_.core;
  for (std::size_t i = 0; i < core.code_writes; ++i) cache_.memory_written(core.code_written[i]);
  core.code_writes = 0;
  flush_blocks();
}

// A write from outside: it acts at once, and what the program has changed before acts no later.
void Engine::set_status(Word value) {
  cache_.settle_control(std::numeric_limits<Cycles>::max());
  write_status(value);
  cache_.note_control(std::numeric_limits<Cycles>::min());
  settle_cache_control();
}

void Engine::write_status(Word value) {
  Core& core = state_.core;
  const Word count = core.r[reg::RC];
  const bool sets_repeat = (core.modes & st::RM) == 0;
  if (sets_repeat && (count == 0 || count == 0xFFFFFFFFu)) value &= ~st::RM;
  if ((value & st::RM) == 0) core.repeat_single = 0;
  state_.cache_clear |= (value & st::CC) != 0;
  core.set_status(value);
}

void Engine::settle_cache_control() { cache_.settle_control(state_.cycle + pipeline_.get().earliest_fetch()); }

void Engine::watch_pins(PinListener* listener, unsigned outputs, unsigned inputs) {
  pins_.watch(listener, outputs, inputs);
  peripherals_.pins_changed();
}

void Engine::stand_until(Cycles cycle, Cause cause) {
  touch();
  pass(cause, cycle);
  if (pins_.watched() && !state_.held) peripherals_.advance_to(state_.cycle);
  peripherals_.give_all_dma_inputs();
}

// A held chip drives no pin. No listener sees what its timers would have done meanwhile. An access that waits begins
// again afterwards: until its caller knows of it, it limits the DMA and the timers beside it.
void Engine::hold(bool held) {
  touch();
  access_.set_reported(false);
  if (pins_.watched() && held != state_.held) peripherals_.advance_to(state_.cycle);
  state_.held = held;
  peripherals_.pins_changed();
}

}  // namespace c40
