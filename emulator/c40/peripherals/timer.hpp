#pragma once
/// One of the two timers (c40-hardware.md 4). Its state is computed when it is needed; there is no step per cycle.
///
/// Inaccuracies: the internal clock's phase begins with the write that starts the timer. An external tick counts in the
/// cycle in which the pin's level is set. Bits 31, 30 of the control register (run while the debugger halts the chip)
/// are kept without effect.
#include <cstddef>

#include "c40/peripherals/fields.hpp"
#include "c40/pipeline/timing_parameters.hpp"

namespace state {
class Visitor;
}

namespace c40 {

inline constexpr int timer_count = 2;

/// The timer's control register.
namespace timer_control {
inline constexpr Field FUNC{"FUNC", 0, 1, FieldAccess::read_write,
                            "1: TCLK is the timer's pin; 0: general-purpose I/O"};
inline constexpr Field IO{"I/O", 1, 1, FieldAccess::read_write, "with FUNC 0: 1 output, 0 input"};
inline constexpr Field DATOUT{"DATOUT", 2, 1, FieldAccess::read_write, "level of a general-purpose output"};
inline constexpr Field DATIN{"DATIN", 3, 1, FieldAccess::read_only, "level of the pin"};
inline constexpr Field GO{"GO", 6, 1, FieldAccess::write_only, "1: counter to zero; with HLD 1, start. Reads 0"};
inline constexpr Field HLD{"HLD", 7, 1, FieldAccess::read_write, "0: counter frozen; 1: it runs"};
inline constexpr Field CP{"C/P", 8, 1, FieldAccess::read_write, "1: clock mode, TSTAT toggles; 0: pulse mode"};
inline constexpr Field CLKSRC{"CLKSRC", 9, 1, FieldAccess::read_write, "1: H1/2; 0: the pin"};
inline constexpr Field INV{"INV", 10, 1, FieldAccess::read_write, "1: the pin is inverted"};
inline constexpr Field TSTAT{"TSTAT", 11, 1, FieldAccess::read_only, "status of the timer, before inversion"};
inline constexpr Field DEBUG{"DEBUG", 30, 2, FieldAccess::read_write, "run while the debugger halts the chip"};
}  // namespace timer_control

enum class TimerRegister : std::uint8_t { control = 0, counter = 4, period = 8 };

/// Timer registers are at 100020h + 10h * n (c40-hardware.md 1.3).
bool is_timer_register(Address address);
std::size_t timer_of(Address address);
TimerRegister timer_register(Address address);

class Timer {
 public:
  /// A register's value in a cycle, which must not be before the last call of advance_to or write.
  Word read(TimerRegister reg, Cycles at) const;
  /// A write of the processor overrides the timer's own change of that register in that cycle, and of nothing else.
  /// True if TSTAT went from 0 to 1.
  bool write(TimerRegister reg, Word value, Cycles at);
  /// The chip is held for so many cycles, in which the timer does not count: all that is to come comes later.
  void stand_still(Cycles cycles) { at_ += cycles; }
  /// The level at the pin TCLK while the chip is held: it is no tick.
  void follow_pin(bool level) { outside_ = level; }
  /// Reset; the level that the outside drives stays.
  void restart(const Timer& before) { outside_ = before.outside_; }
  /// The timer counts edges of the pin TCLK.
  bool counts_pin() const { return running() && !internal_clock(); }
  /// The outside drives the pin TCLK to a level from cycle `at` on; true if this changed TSTAT from 0 to 1.
  bool set_pin(bool level, Cycles at);
  /// The level at the pin TCLK.
  bool pin(Cycles at) const;
  bool drives_pin() const;

  /// The cycle of the next TINT (TSTAT goes from 0 to 1); the greatest number if the timer alone will cause none.
  Cycles next_event() const;
  /// The first cycle after `last` in which the timer changes the level that it drives; the greatest number if there is
  /// none.
  Cycles next_change_of_pin(Cycles last) const;
  /// Advances to a cycle; true if TSTAT went from 0 to 1 on the way.
  bool advance_to(Cycles at);

  void list_state(state::Visitor& list);
  friend bool operator==(const Timer&, const Timer&) = default;

 private:
  bool running() const { return timer_control::HLD.in(control_); }
  bool internal_clock() const { return timer_control::CLKSRC.in(control_); }
  bool clock_mode() const { return timer_control::CP.in(control_); }
  bool stuck() const;
  bool status(Cycles at) const;
  bool clock_line(Cycles at) const;
  Cycles tick_cycles() const;
  std::uint64_t ticks_to_overflow() const;
  bool count(std::uint64_t ticks, Cycles last);
  bool write_control(Word value, Cycles at);
  void skip_ticks(Cycles at);

  Word control_ = 0;  ///< without DATIN, GO and TSTAT
  Word counter_ = 0, period_ = 0;
  Cycles at_ = 0;         ///< the cycle for which counter_ and toggle_ hold: a tick of the internal clock
  bool toggle_ = false;   ///< TSTAT in clock mode
  Cycles pulse_ = -1;     ///< the cycle in which TSTAT is 1 in pulse mode
  bool outside_ = false;  ///< the level that the outside drives
};

}  // namespace c40
