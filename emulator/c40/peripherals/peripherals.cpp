#include "c40/peripherals/peripherals.hpp"

#include <algorithm>

#include "c40/chip/interrupts.hpp"
#include "state/visitor.hpp"

namespace c40 {
namespace {

using interrupts::iiof_flag;
using interrupts::timer_flags;

// An event that DIE selects for a started channel goes to the DMA instead of IIF (c40-hardware.md 3.8). Codes of
// channels 0 and 1: 2 an IIOF pin of their own, 3 timer 0; of the others: 2 to 5 IIOF0 to 3, 6 and 7 the timers.
auto selects(Word flag) {
  return [flag](int channel, bool write, Word code) -> bool {
    const unsigned own_pin = static_cast<unsigned>(2 * channel + write);
    for (unsigned pin = 0; pin < 4; ++pin)
      if (flag == iiof_flag(pin)) return channel < 2 ? code == 2 && pin == own_pin : code == 2 + pin;
    if (flag == interrupts::timer0_flag) return code == (channel < 2 ? 3u : 6u);
    return flag == interrupts::timer1_flag && channel >= 2 && code == 7;
  };
}

}  // namespace

// ---- registers ----

bool Peripherals::read(Address address, Cycles at, Word& value) const {
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

bool Peripherals::write(Address address, Word value, Cycles at) {
  if (address == global_interface || address == local_interface) {
    Word& control = address == global_interface ? state_.global_interface_control : state_.local_interface_control;
    control = (control & ~InterfaceControl::writable) | (value & InterfaceControl::writable);
    interface_changed_ = true;
    return true;
  }
  if (is_timer_register(address)) {
    advance_to(at);
    if (state_.timers[timer_of(address)].write(timer_register(address), value, at)) timer_event(timer_of(address), at);
    if (pins_.watched()) pins_.tell(at);
    expect();
    return true;
  }
  if (is_dma_register(address)) {
    dma_.write(dma_channel_of(address), dma_register(address), value, at);
    watch_dma();
    return true;
  }
  return false;
}

bool Peripherals::write_by_processor(Address address, Word value, Cycles at) {
  if (!is_dma_register(address) || !dma_active_) return write(address, value, at);
  advance_to(at);  // the timers' events of the cycle come first
  if (!dma_is_behind(at)) return write(address, value, at);
  note({DmaInput::Kind::write, at, value, address});
  return true;
}

void Peripherals::interrupt_enable_written(Word before, Cycles at) {
  note({DmaInput::Kind::interrupt_enable, at, before, 0});
  advance_to(at);  // the timers' events of the cycle come first
  if (dma_.busy() || dma_.ends()) return;
  dma_.rest_until(at);
  give_dma_inputs(at);
}

// ---- what the DMA learns when it comes to the cycle ----

void Peripherals::note(const DmaInput& input) {
  dma_inputs_.insert(std::ranges::upper_bound(dma_inputs_, input.at, {}, &DmaInput::at), input);
}

void Peripherals::give_dma_inputs(Cycles at) {
  while (next_dma_input() <= at && has_dma_input()) {
    const DmaInput input = dma_inputs_.front();
    dma_inputs_.erase(dma_inputs_.begin());
    give(input);
  }
  watch_dma();
}

void Peripherals::give(const DmaInput& input) {
  switch (input.kind) {
    case DmaInput::Kind::event:
      if (!dma_.latch(selects(input.value))) set_flag(input.value);
      break;
    case DmaInput::Kind::write:
      dma_.write(dma_channel_of(input.address), dma_register(input.address), input.value, input.at);
      break;
    case DmaInput::Kind::interrupt_enable: dma_.interrupt_enable_changed(input.value, input.at); break;
  }
}

Word Peripherals::dma_interrupt_enable_before() const {
  const auto change = std::ranges::find(dma_inputs_, DmaInput::Kind::interrupt_enable, &DmaInput::kind);
  return change != dma_inputs_.end() ? change->value : state_.core.r[reg::DIE];
}

void Peripherals::delay_dma_inputs(Cycles cycles) {
  for (DmaInput& input : dma_inputs_) input.at += cycles;
}

// ---- events ----

void Peripherals::raise(Word flag, Cycles at) {
  const Word iif = state_.core.r[reg::IIF];
  for (unsigned pin = 0; pin < 4; ++pin)
    if (flag == iiof_flag(pin) && (iif >> 4 * pin & 1u) == 0) return;  // general-purpose I/O
  if (!dma_.latches(selects(flag))) return set_flag(flag);
  if (dma_is_behind(at)) return note({DmaInput::Kind::event, at, flag, 0});
  if (dma_active_) dma_.rest_until(at);  // it has waited
  dma_.latch(selects(flag));
}

void Peripherals::set_flag(Word flag) {
  for (unsigned pin = 0; pin < 4; ++pin)
    if (flag == iiof_flag(pin) && interrupts::is_level_triggered(state_.core, pin)) return;  // Pins::show_inputs
  state_.core.r[reg::IIF] |= flag;
}

void Peripherals::timer_event(std::size_t timer, Cycles at) {
  raise(timer_flags[timer], at);
  tell_({PeripheralEvent::Kind::timer, at, static_cast<int>(timer)});
}

void Peripherals::set_pin(Pin pin, bool level, Cycles at) {
  const unsigned n = number_of(pin);
  if (pin == Pin::nmi) {
    if (!level && !state_.nmi_low) raise(interrupts::nmi_flag, at);
    state_.nmi_low = !level;
  } else if (is_timer_pin(pin)) {
    if (state_.held) return state_.timers[n].follow_pin(level);
    advance_to(at - 1);
    if (state_.timers[n].set_pin(level, at)) timer_event(n, at);
    expect();
  } else if (is_iiof(pin)) {
    if (pins_.set_iiof(pin, level)) raise(iiof_flag(n), at);
    pins_.show_inputs();
  }
}

bool Peripherals::reacts_to(Pin pin) const {
  const unsigned n = number_of(pin);
  if (is_iiof(pin))
    return (interrupts::iiof_nibble(state_.core, n) & 9u) == 9u || (dma_active_ && dma_.latches(selects(iiof_flag(n))));
  if (is_timer_pin(pin))
    return state_.timers[n].counts_pin() &&
           (timer_drives_dma(n) ? dma_active_ : (state_.core.r[reg::IIE] & (n == 0 ? 1u : 1u << 31)) != 0);
  return true;
}

bool Peripherals::timer_drives_dma(std::size_t timer) const { return dma_.latches(selects(timer_flags[timer])); }

void Peripherals::pins_changed() {
  if (!pins_.watched()) return;
  pins_.tell(state_.cycle);
  expect();
}

// ---- changes without an access ----

void Peripherals::end_dma_block(Cycles at) {
  if (!dma_.ends_at(at)) return;
  dma_.end();
  watch_dma();
}

void Peripherals::advance_to(Cycles at) {
  while (next_event_ <= at) {
    const Cycles event = next_event_;
    end_dma_block(event);
    for (std::size_t n = 0; n < timer_count; ++n)
      if (state_.timers[n].advance_to(event)) timer_event(n, event);
    if (pins_.watched()) pins_.tell(event);
    expect();
  }
}

void Peripherals::expect() {
  next_event_ = std::min(state_.timers[0].next_event(), state_.timers[1].next_event());
  if (pins_.watched()) next_event_ = std::min(next_event_, pins_.next_change());
}

void Peripherals::watch_dma() { dma_active_ = dma_.active() || state_.dma.waits_for_answer || has_dma_input(); }

void Peripherals::state_changed() {
  watch_dma();
  expect();
}

void Peripherals::was_reset() {
  dma_inputs_.clear();
  state_changed();
}

void Peripherals::list_state(state::Visitor& list) {
  list("interface_changed", interface_changed_);
  list("dma_inputs", dma_inputs_);
}

}  // namespace c40
