// The pins: what the outside drives them to, and what the chip drives.
#include <utility>

#include "c40/engine.hpp"

namespace c40 {
namespace {

constexpr Word nmi_flag = 1u << 16;
constexpr unsigned bit(Pin pin) { return 1u << static_cast<unsigned>(pin); }
constexpr Word flag_of(unsigned pin) { return 4u << 4 * pin; }

}  // namespace

// ---- from outside ----

void Engine::raise_flag(Word flag) {
  Word& iif = state_.core.r[reg::IIF];
  for (unsigned pin = 0; pin < 4; ++pin)
    if (flag == flag_of(pin) && (iif >> 4 * pin & 1u) == 0) return;  // general-purpose I/O
  if (latch_for_dma(flag)) return;
  iif |= flag;
}

void Engine::set_pin(Pin pin, bool level, Cycles at) {
  const unsigned n = number_of(pin);
  if (pin == Pin::nmi) {
    if (!level && !state_.nmi_low) raise_flag(nmi_flag);
    state_.nmi_low = !level;
  } else if (is_timer_pin(pin)) {
    advance_peripherals(at - 1);
    if (state_.timers[n].set_pin(level, at)) timer_event(n, at);
    expect_peripherals();
  } else if (is_iiof(pin)) {
    const bool was_low = (state_.iiof_levels & bit(pin)) != 0;
    state_.iiof_driven = static_cast<std::uint8_t>(state_.iiof_driven | bit(pin));
    state_.iiof_levels = static_cast<std::uint8_t>(level ? state_.iiof_levels & ~bit(pin) : state_.iiof_levels | bit(pin));
    if (!level && !was_low) raise_flag(flag_of(n));
    after_interrupt_register_write();
  }
}

// FLAG of a general-purpose input is read only: the level at the pin.
void Engine::after_interrupt_register_write() {
  Word& iif = state_.core.r[reg::IIF];
  for (unsigned pin = 0; pin < 4; ++pin)
    if ((iif >> 4 * pin & 3u) == 0) iif = (iif & ~flag_of(pin)) | (level_at_iiof(pin) ? flag_of(pin) : 0u);
}

/// What the outside drives it to, else what the board ties it to.
bool Engine::level_at_iiof(unsigned pin) const {
  if ((state_.iiof_driven >> pin & 1u) != 0) return (state_.iiof_levels >> pin & 1u) == 0;
  return (board_.pins.iiof >> pin & 1u) != 0;
}

bool Engine::iiof_pin(int pin) const {
  const auto n = static_cast<unsigned>(pin);
  const Word nibble = state_.core.r[reg::IIF] >> 4 * n & 0xFu;
  const bool output = (nibble & 3u) == 2;
  return output ? (nibble & 4u) != 0 : level_at_iiof(n);
}

bool Engine::heeds(Pin pin) const {
  const unsigned n = number_of(pin);
  if (is_iiof(pin)) {
    const Word nibble = state_.core.r[reg::IIF] >> 4 * n & 0xFu;
    return (nibble & 9u) == 9u || (dma_active_ && pin_drives_dma(n));
  }
  if (is_timer_pin(pin)) return state_.timers[n].counts_pin() && (timer_drives_dma(n) || (state_.core.r[reg::IIE] & (n == 0 ? 1u : 1u << 31)) != 0);
  return true;
}

// ---- to the outside ----

void Engine::watch_pins(PinListener* listener, unsigned outputs, unsigned inputs) {
  pin_listener_ = listener;
  watched_pins_ = listener != nullptr ? outputs : 0;
  driven_pins_ = inputs;
  pins_changed();
}

Drive Engine::drive_of(Pin pin, Cycles at) const {
  if (state_.held) return Drive::none;
  const unsigned n = number_of(pin);
  if (is_iiof(pin)) {
    const Word nibble = state_.core.r[reg::IIF] >> 4 * n & 0xFu;
    return (nibble & 3u) == 2 ? drive_to((nibble & 4u) != 0) : Drive::none;
  }
  const Timer& timer = state_.timers[n];
  return timer.drives_pin() ? drive_to(timer.pin(at)) : Drive::none;
}

/// One that both the outside and the chip drive.
std::optional<Pin> Engine::contended_pin() const {
  for (std::size_t n = 0; n < pin_count; ++n) {
    const auto pin = static_cast<Pin>(n);
    if ((driven_pins_ & bit(pin)) != 0 && can_be_output(pin) && drive_of(pin, state_.cycle) != Drive::none) return pin;
  }
  return {};
}

void Engine::tell_pins(Cycles at) {
  state_.drives_told = at;
  for (std::size_t n = 0; n < pin_count; ++n) {
    if ((watched_pins_ >> n & 1u) == 0) continue;
    const Drive drive = drive_of(static_cast<Pin>(n), at);
    if (drive != std::exchange(state_.drives[n], drive)) pin_listener_->driven(static_cast<Pin>(n), drive, at);
  }
}

void Engine::pins_changed() {
  if (watched_pins_ == 0) return;
  tell_pins(state_.cycle);
  expect_peripherals();
}

void Engine::stand_until(Cycles cycle) {
  touch();
  pass(Cause::halted, cycle);
  if (watched_pins_ != 0 && !state_.held) advance_peripherals(state_.cycle);
}

// One that is held drives nothing. What its timers would have done meanwhile nobody has seen.
void Engine::hold(bool held) {
  touch();
  if (watched_pins_ != 0 && held != state_.held) advance_peripherals(state_.cycle);
  state_.held = held;
  pins_changed();
}

}  // namespace c40
