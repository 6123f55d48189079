#pragma once
/// The pins of a chip: the levels that the chip reads and drives, and the listener of the driven levels.
#include <optional>

#include "c40/chip/board.hpp"
#include "c40/chip/state.hpp"
#include "c40/peripherals/pins.hpp"

namespace c40 {

class Pins {
 public:
  /// \param tied the levels to which the board ties pins
  Pins(State& state, const Board::Pins& tied) : state_(state), tied_(tied) {}

  /// The listener is called for the pins whose bits are set in `outputs`; the pins in `inputs` have other drivers.
  void watch(PinListener* listener, unsigned outputs, unsigned inputs);
  bool watched() const { return watched_ != 0; }
  /// A pin has another driver.
  bool driven() const { return driven_ != 0; }

  /// The level at IIOFn: the chip's output, else the outside's level, else the level that the board ties.
  bool level(unsigned pin) const;
  /// The outside drives IIOFn; returns true if IIOFn went low.
  bool set_iiof(Pin pin, bool level);
  /// Updates FLAG of general-purpose inputs, which is the pin's level and read only; and of level-triggered interrupts,
  /// which is 1 as long as the outside holds the pin low. Call it after each write to IIF, and each change of a pin.
  void show_inputs();

  /// A pin that both the outside and the chip drive.
  std::optional<Pin> contended() const;
  /// Reports to the listener what has changed up to cycle `at`.
  void tell(Cycles at);
  /// When a watched pin of a timer next changes by itself; the greatest number if never.
  Cycles next_change() const;

 private:
  bool input_level(unsigned pin) const;
  Drive drive_of(Pin pin, Cycles at) const;

  State& state_;
  const Board::Pins& tied_;
  PinListener* listener_ = nullptr;
  unsigned watched_ = 0;  ///< bit n: pin n is an output with a listener
  unsigned driven_ = 0;   ///< bit n: pin n is an input with another driver
};

}  // namespace c40
