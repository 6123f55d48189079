#include "c40/chip/chip_pins.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "c40/chip/interrupts.hpp"

namespace c40 {
namespace {

constexpr unsigned iiof_pins = 4;
constexpr unsigned bit(Pin pin) { return 1u << static_cast<unsigned>(pin); }

}  // namespace

void Pins::watch(PinListener* listener, unsigned outputs, unsigned inputs) {
  listener_ = listener;
  watched_ = listener != nullptr ? outputs : 0;
  driven_ = inputs;
}

bool Pins::input_level(unsigned pin) const {
  if ((state_.iiof_driven >> pin & 1u) != 0) return (state_.iiof_levels >> pin & 1u) == 0;
  return (tied_.iiof >> pin & 1u) != 0;
}

bool Pins::level(unsigned pin) const {
  const Word nibble = interrupts::iiof_nibble(state_.core, pin);
  const bool output = (nibble & 3u) == 2;
  return output ? (nibble & 4u) != 0 : input_level(pin);
}

bool Pins::set_iiof(Pin pin, bool level) {
  const bool was_low = (state_.iiof_levels & bit(pin)) != 0;
  state_.iiof_driven = static_cast<std::uint8_t>(state_.iiof_driven | bit(pin));
  state_.iiof_levels =
      static_cast<std::uint8_t>(level ? state_.iiof_levels & ~bit(pin) : state_.iiof_levels | bit(pin));
  return !level && !was_low;
}

void Pins::show_inputs() {
  Word& iif = state_.core.r[reg::IIF];
  const auto show = [&iif](unsigned pin, bool flag) {
    iif = (iif & ~interrupts::iiof_flag(pin)) | (flag ? interrupts::iiof_flag(pin) : 0u);
  };
  for (unsigned pin = 0; pin < iiof_pins; ++pin) {
    if ((iif >> 4 * pin & 3u) == 0)
      show(pin, input_level(pin));
    else if (interrupts::is_level_triggered(state_.core, pin))
      show(pin, (state_.iiof_levels >> pin & 1u) != 0);
  }
}

Drive Pins::drive_of(Pin pin, Cycles at) const {
  if (state_.held) return Drive::none;
  const unsigned n = number_of(pin);
  if (is_iiof(pin)) {
    const Word nibble = interrupts::iiof_nibble(state_.core, n);
    return (nibble & 3u) == 2 ? drive_to((nibble & 4u) != 0) : Drive::none;
  }
  const Timer& timer = state_.timers[n];
  return timer.drives_pin() ? drive_to(timer.pin(at)) : Drive::none;
}

std::optional<Pin> Pins::contended() const {
  for (std::size_t n = 0; n < pin_count; ++n) {
    const auto pin = static_cast<Pin>(n);
    if ((driven_ & bit(pin)) != 0 && can_be_output(pin) && drive_of(pin, state_.cycle) != Drive::none) return pin;
  }
  return {};
}

void Pins::tell(Cycles at) {
  state_.drives_reported = at;
  for (std::size_t n = 0; n < pin_count; ++n) {
    if ((watched_ >> n & 1u) == 0) continue;
    const Drive drive = drive_of(static_cast<Pin>(n), at);
    if (drive != std::exchange(state_.drives[n], drive)) listener_->driven(static_cast<Pin>(n), drive, at);
  }
}

Cycles Pins::next_change() const {
  Cycles next = std::numeric_limits<Cycles>::max();
  for (const Pin pin : {Pin::tclk0, Pin::tclk1})
    if ((watched_ & bit(pin)) != 0)
      next = std::min(next, state_.timers[number_of(pin)].next_change_of_pin(state_.drives_reported));
  return next;
}

}  // namespace c40
