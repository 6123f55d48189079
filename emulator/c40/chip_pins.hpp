#pragma once
/// The pins of a chip: the levels that it reads, and what it drives, with whoever listens to that.
#include <optional>

#include "c40/board.hpp"
#include "c40/peripherals/pins.hpp"
#include "c40/state.hpp"

namespace c40 {

class Pins {
 public:
  /// \param tied what the board ties the pins to
  Pins(State& state, const Board::Pins& tied) : state_(state), tied_(tied) {}

  /// The listener is told of the pins of which the bits are set in `outputs`; others drive those in `inputs`.
  void watch(PinListener* listener, unsigned outputs, unsigned inputs);
  bool watched() const { return watched_ != 0; }
  /// Others drive some pin.
  bool driven() const { return driven_ != 0; }

  /// The level at IIOFn: an output's, else what the outside drives it to, else what the board ties it to.
  bool level(unsigned pin) const;
  /// The outside drives IIOFn; true: it went low.
  bool set_iiof(Pin pin, bool level);
  /// FLAG of a general-purpose input is read only: the level at the pin. After each write to IIF, or to a pin.
  void show_inputs();

  /// A pin that both the outside and the chip drive.
  std::optional<Pin> contended() const;
  /// Tells what has changed up to cycle `at`.
  void tell(Cycles at);
  /// When a watched pin of a timer changes next by itself; the greatest number if none does.
  Cycles next_change() const;

 private:
  bool input_level(unsigned pin) const;
  Drive drive_of(Pin pin, Cycles at) const;

  State& state_;
  const Board::Pins& tied_;
  PinListener* listener_ = nullptr;
  unsigned watched_ = 0;  ///< bit n: pin n is an output that somebody listens to
  unsigned driven_ = 0;   ///< bit n: pin n is an input that others drive
};

}  // namespace c40
