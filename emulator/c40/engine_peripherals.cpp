// What surrounds the processor core on the chip: its registers in memory, and the interrupts.
#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "c40/choices.hpp"
#include "c40/engine.hpp"
#include "c40/engine_dma.hpp"

namespace c40 {
namespace {

constexpr Address global_interface = peripheral_base + 0x00, local_interface = peripheral_base + 0x04;
constexpr Word nmi_flag = 1u << 16, timer0_flag = 1u << 24, timer1_flag = 1u << 31;
constexpr std::array timer_flags{timer0_flag, timer1_flag};
constexpr Word port_sources = 0x01FFFFFEu;  // of IIE

// What DIE selects for a started channel goes to the DMA instead of IIF (3.8). Codes of channels 0 and 1: 2 an IIOF pin of
// their own, 3 timer 0; of the others: 2 to 5 IIOF0 to 3, 6 and 7 the timers.
auto selects(Word flag) {
  return [flag](int channel, bool write, Word code) -> bool {
    const unsigned own_pin = static_cast<unsigned>(2 * channel + write);
    for (unsigned pin = 0; pin < 4; ++pin)
      if (flag == 4u << 4 * pin) return channel < 2 ? code == 2 && pin == own_pin : code == 2 + pin;
    if (flag == timer0_flag) return code == (channel < 2 ? 3u : 6u);
    return flag == timer1_flag && channel >= 2 && code == 7;
  };
}

}  // namespace

// ---- registers on the chip ----

bool Engine::read_register(Address address, Cycles at, Word& value) const {
  if (address == global_interface || address == local_interface) {
    value = address == global_interface ? state_.global_interface_control : state_.local_interface_control;
    return true;
  }
  if (is_port_register(address)) {
    const PortAccess access = port_access(address, false, 0, 0);
    return access.peek(state_.ports[static_cast<std::size_t>(access.port)], value);
  }
  if (is_timer_register(address)) {
    value = state_.timers[timer_of(address)].read(timer_register(address), at);
    return true;
  }
  if (is_dma_register(address)) {
    value = dma_.read(dma_channel_of(address), dma_register(address));
    return true;
  }
  return false;
}

bool Engine::write_register(Address address, Word value, Cycles at) {
  if (address == global_interface || address == local_interface) {
    Word& control = address == global_interface ? state_.global_interface_control : state_.local_interface_control;
    control = (control & ~InterfaceControl::writable) | (value & InterfaceControl::writable);
    interface_changed_ = true;
    return true;
  }
  if (is_timer_register(address)) {
    advance_peripherals(at - 1);
    if (state_.timers[timer_of(address)].write(timer_register(address), value, at)) timer_event(timer_of(address), at);
    if (watched_pins_ != 0) tell_pins(at);
    expect_peripherals();
    return true;
  }
  if (is_dma_register(address)) {
    dma_.write(dma_channel_of(address), dma_register(address), value, at);
    if (dma_register(address) == DmaRegister::control && dma_control::START.of(value) == dma_control::start_run)
      tell(PeripheralEvent::Kind::dma_start, at, dma_channel_of(address), value);
    watch_dma();
    return true;
  }
  return false;
}

// ---- what goes on by itself ----

void Engine::tell(PeripheralEvent::Kind kind, Cycles cycle, int number, Word value, int channel) {
  if (peripheral_sink != nullptr) peripheral_sink->happened({kind, cycle, number, value, channel});
}

void Engine::timer_event(std::size_t timer, Cycles at) {
  raise_flag(timer_flags[timer]);
  tell(PeripheralEvent::Kind::timer, at, static_cast<int>(timer));
}

// In one cycle, a block of the DMA ends before the timers' events and the processor's access to a port.
void Engine::end_dma_block(Cycles at) {
  if (!dma_.ends_at(at)) return;
  dma_.end();
  watch_dma();
}

void Engine::advance_peripherals(Cycles at) {
  while (next_peripheral_event_ <= at) {
    const Cycles event = next_peripheral_event_;
    end_dma_block(event);
    for (std::size_t n = 0; n < timer_count; ++n)
      if (state_.timers[n].advance_to(event)) timer_event(n, event);
    if (watched_pins_ != 0) tell_pins(event);
    expect_peripherals();
  }
}

void Engine::expect_peripherals() {
  next_peripheral_event_ = std::min(state_.timers[0].next_event(), state_.timers[1].next_event());
  if (watched_pins_ == 0) return;
  for (const Pin pin : {Pin::tclk0, Pin::tclk1})
    if ((watched_pins_ >> static_cast<unsigned>(pin) & 1u) != 0)
      next_peripheral_event_ = std::min(next_peripheral_event_, state_.timers[number_of(pin)].next_change_of_pin(state_.drives_told));
}

// ---- communication ports ----

void Engine::attach(int n, PortListener* link) {
  listeners_[static_cast<std::size_t>(n)] = link;
  attached_ = (attached_ & ~(1u << n)) | (link != nullptr ? 1u << n : 0u);
}

void Engine::reset_ports() {
  for (int n = 0; n < port_count; ++n) {
    port(n).reset(n);
    if (PortListener* link = listener(n); link != nullptr) link->was_reset(port(n), state_.cycle);
  }
}

// What the access finds. One that a link is concerned with, or that has to wait, stops the chip first.
Engine::Stepped Engine::access_port(const Step& step, std::size_t k, Word& cell) {
  const Core& core = state_.core;
  const Answer& answer = state_.answers[k];
  const bool write = core.miss_write;
  if (!answer.given || answer.address != core.miss_address || answer.write != write) {
    port_access_ = port_access(core.miss_address, write, write ? core.miss_value : 0, access_cycle(step, k));
    held_ = std::max<Cycles>(0, state_.dma.answered_until - port_access_.cycle);
    port_access_.cycle += held_;
    port_slot_ = k;
    waiting_access_ = 2;
    if (listener(port_access_.port) != nullptr || !port_access_.ready(port(port_access_.port))) {
      state_.stalled_on_port = true;
      return Stepped::port;
    }
    complete_port(port_access_.cycle);
  }
  cell = answer.value;
  return Stepped::done;
}

void Engine::tell_word(const PortAccess& access, Word read, Cycles at, int channel) {
  if (access.reg == PortRegister::output && access.write) tell(PeripheralEvent::Kind::port_write, at, access.port, access.value, channel);
  if (access.reg == PortRegister::input && !access.write) tell(PeripheralEvent::Kind::port_read, at, access.port, read, channel);
}

void Engine::forget_access() {
  waiting_access_ = port_slot_ = 2;
  state_.stalled_on_port = false;
}

void Engine::complete_port(Cycles at) {
  if (port_slot_ >= 2) throw std::logic_error("the chip waits for no communication port");
  CommPort& side = port(port_access_.port);
  if (!port_access_.ready(side))
    throw std::logic_error(fmt::format("communication port {}: the {} FIFO is {}", port_access_.port, port_access_.write ? "output" : "input",
                                       port_access_.write ? "full" : "empty"));
  if (at < port_access_.cycle) throw std::logic_error("an access cannot take place before it begins");
  end_dma_block(at);
  advance_peripherals(at);
  const Word value = port_access_.perform(side);
  state_.answers[port_slot_] = {true, port_access_.write, port_access_.address, value, 0, 0, at - port_access_.cycle + held_};
  state_.stalled_on_port = false;
  port_slot_ = 2;
  tell_word(port_access_, value, at, -1);
  if (PortListener* link = listener(port_access_.port); link != nullptr) link->changed(side, at);
}

// ---- interrupts ----

Word Engine::pending_vector() const {
  const Core& core = state_.core;
  const Word iif = core.r[reg::IIF], iie = core.r[reg::IIE];
  if ((iif & nmi_flag) != 0) return 1;
  if ((core.modes & st::GIE) == 0) return 0;
  if ((iif & timer0_flag) != 0 && (iie & 1u) != 0) return 2;
  for (unsigned pin = 0; pin < 4; ++pin) {
    const Word nibble = iif >> 4 * pin & 0xFu;
    const bool requested = (nibble & 4u) != 0 || ((nibble & 2u) != 0 && (state_.iiof_levels >> pin & 1u) != 0);
    if ((nibble & 9u) == 9u && requested) return 3 + pin;
  }
  if ((iie & port_sources) != 0)
    if (const Word vector = pending_port_vector(iie); vector != 0) return vector;
  for (unsigned channel = 0; channel < 6; ++channel)
    if ((iif & iie) >> (25 + channel) & 1u) return 0x25 + channel;
  return (iif & iie & timer1_flag) != 0 ? 0x2Bu : 0u;
}

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
  const Word old = core.modes;
  core.modes = (old & ~(st::PGIE | st::PCF | st::GIE)) | (old & st::GIE ? st::PGIE : 0u) | (old & st::CF ? st::PCF : 0u) | (choices::entry_sets_cache_freeze ? st::CF : 0u);
  Word& iif = core.r[reg::IIF];
  if (vector == 1) iif &= ~nmi_flag;
  if (vector == 2) iif &= ~timer0_flag;
  if (vector >= 3 && vector <= 6) iif &= ~(4u << 4 * (vector - 3));
  if (vector >= 0x25 && vector <= 0x2A) iif &= ~(1u << (vector - 0xC));
  if (vector == 0x2B) iif &= ~timer1_flag;
  core.idle = false;
  const int waits = memory_.meet(*table, entry, false, state_.open_pages).access.waits + memory_.meet(*stack, top, true, state_.open_pages).access.waits;
  add(state_.causes, Cause::interrupt, timing::interrupt_entry_cost);
  add(state_.causes, Cause::wait_state, waits);
  state_.cycle += timing::interrupt_entry_cost + waits;
  auto undisturbed = dma_side_->undisturbed;
  touch().pipeline.flush(timing::interrupt_entry_cost + waits);
  if (undisturbed) {
    Pipeline alone = pipelines_[*undisturbed];
    alone.flush(timing::interrupt_entry_cost + waits);
    dma_side_->undisturbed = pipelines_.intern(alone);
  }
  if (dma_active_) dma_side_->mark_under_way();
  note_cache_control(before);
  if (trace != nullptr) trace->interrupt(vector, before);
  tell(PeripheralEvent::Kind::interrupt, before, static_cast<int>(vector), peek(top));
  return true;
}

// Levels, not latched (2.3): 0Dh + 4n ICFULL, then ICRDY, OCRDY, OCEMPTY, in the order of their bits in IIE.
Word Engine::pending_port_vector(Word enabled) const {
  for (unsigned n = 0; n < port_count; ++n) {
    const CommPort& port = state_.ports[n];
    const std::array<bool, 4> active{port.icfull(), port.icrdy(), port.ocrdy(), port.ocempty()};
    for (unsigned source = 0; source < 4; ++source)
      if (active[source] && (enabled >> (1 + 4 * n + source) & 1u) != 0) return 0x0D + 4 * n + source;
  }
  return 0;
}

Word Engine::watched_ports() const {
  if (attached_ == 0) return 0;
  const Word enabled = state_.core.r[reg::IIE] & port_sources;
  Word watched = 0;
  for (unsigned n = 0; enabled >> 4 * n != 0; ++n)
    if ((enabled >> (1 + 4 * n) & 0xFu) != 0) watched |= 1u << n;
  if (dma_active_) watched |= dma_.ports_used();
  return watched & attached_;
}

bool Engine::latch_for_dma(Word flag) { return dma_active_ && dma_.latch(selects(flag)); }

bool Engine::timer_drives_dma(std::size_t timer) const { return dma_active_ && dma_.latches(selects(timer_flags[timer])); }
bool Engine::pin_drives_dma(unsigned pin) const { return dma_active_ && dma_.latches(selects(4u << 4 * pin)); }

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
  poke(global_interface, interface_after_reset);
  poke(local_interface, interface_after_reset);
}

}  // namespace c40
