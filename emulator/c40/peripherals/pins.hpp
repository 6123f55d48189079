#pragma once
/// The pins of a chip that nets connect (machine/networks/net.hpp): those that the outside drives, and those that the
/// chip drives.
#include <array>
#include <cstdint>
#include <string_view>

#include "c40/values/types.hpp"

namespace c40 {

enum class Pin : std::uint8_t { iiof0, iiof1, iiof2, iiof3, tclk0, tclk1, nmi, reset };
inline constexpr std::size_t pin_count = 8;

constexpr std::string_view name(Pin pin) {
  constexpr std::array<std::string_view, pin_count> names{"IIOF0", "IIOF1", "IIOF2", "IIOF3",
                                                          "TCLK0", "TCLK1", "NMI",   "RESET"};
  return names[static_cast<std::size_t>(pin)];
}

constexpr bool is_iiof(Pin pin) { return pin <= Pin::iiof3; }
constexpr bool is_timer_pin(Pin pin) { return pin == Pin::tclk0 || pin == Pin::tclk1; }
/// Pins that a chip can drive: general-purpose outputs IIOF, and TCLK as a timer's output or a general-purpose output.
constexpr bool can_be_output(Pin pin) { return is_iiof(pin) || is_timer_pin(pin); }
/// The number n of IIOFn, TCLKn.
constexpr unsigned number_of(Pin pin) {
  return is_timer_pin(pin) ? static_cast<unsigned>(pin) - static_cast<unsigned>(Pin::tclk0)
                           : static_cast<unsigned>(pin);
}

/// What a driver does to a net.
enum class Drive : std::uint8_t { none, low, high };
constexpr Drive drive_to(bool level) { return level ? Drive::high : Drive::low; }

/// Called for every change of a watched output.
class PinListener {
 public:
  virtual ~PinListener() = default;
  /// \param at the first cycle with this level
  virtual void driven(Pin pin, Drive drive, Cycles at) = 0;
};

}  // namespace c40
