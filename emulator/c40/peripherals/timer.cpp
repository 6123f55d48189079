#include "c40/peripherals/timer.hpp"

#include <limits>

namespace c40 {

using namespace timer_control;

namespace {
constexpr Word kept =
    FUNC.mask() | IO.mask() | DATOUT.mask() | HLD.mask() | CP.mask() | CLKSRC.mask() | INV.mask() | DEBUG.mask();
constexpr std::uint64_t counter_range = std::uint64_t{1} << 32;
constexpr Cycles fast_tick_cycles = 1;  // in clock mode with period 0
constexpr Cycles never_happens = std::numeric_limits<Cycles>::max();
constexpr Address first_timer = 0x00100020u;
}  // namespace

bool is_timer_register(Address address) {
  const Address offset = address - first_timer;
  return offset < 0x20 && ((offset & 0xFu) == 0 || (offset & 0xFu) == 4 || (offset & 0xFu) == 8);
}
std::size_t timer_of(Address address) { return (address - first_timer) >> 4; }
TimerRegister timer_register(Address address) { return static_cast<TimerRegister>((address - first_timer) & 0xFu); }

bool Timer::drives_pin() const { return FUNC.in(control_) ? internal_clock() : IO.in(control_); }

// A pulse with which period and counter are 0 lasts until a write changes one of them.
bool Timer::stuck() const { return !clock_mode() && pulse_ >= 0 && period_ == 0 && counter_ == 0; }

bool Timer::status(Cycles at) const {
  if (clock_mode()) return toggle_;
  return pulse_ >= 0 && (at == pulse_ || stuck());
}

bool Timer::pin(Cycles at) const {
  if (!drives_pin()) return outside_;
  if (!FUNC.in(control_)) return DATOUT.in(control_);
  return status(at) != INV.in(control_);
}

bool Timer::clock_line(Cycles at) const { return pin(at) != INV.in(control_); }

Word Timer::read(TimerRegister reg, Cycles at) const {
  Timer then = *this;
  then.advance_to(at);
  switch (reg) {
    case TimerRegister::counter: return then.counter_;
    case TimerRegister::period: return then.period_;
    case TimerRegister::control: break;
  }
  return TSTAT.with(DATIN.with(then.control_, then.pin(at)), then.status(at));
}

bool Timer::write(TimerRegister reg, Word value, Cycles at) {
  bool rose = advance_to(at);
  const bool lasts = stuck();
  switch (reg) {
    case TimerRegister::counter: counter_ = value; break;
    case TimerRegister::period: period_ = value; break;
    case TimerRegister::control:
      if (write_control(value, at)) rose = true;
      break;
  }
  if (pulse_ < at && !(lasts && stuck())) pulse_ = -1;  // a pulse that is over does not begin again
  return rose;
}

void Timer::skip_ticks(Cycles at) { at_ += (at - at_) / tick_cycles() * tick_cycles(); }

bool Timer::write_control(Word value, Cycles at) {
  const bool was_running = running(), was_internal = internal_clock(), line = clock_line(at);
  control_ = value & kept;
  if (GO.in(value)) {
    counter_ = 0;
    toggle_ = false;
    pulse_ = -1;
  }
  if (GO.in(value) || !was_running)
    at_ = at;
  else if (!was_internal)
    skip_ticks(at);  // they were the pin's
  const bool edge = !line && clock_line(at);
  return edge && running() && was_running && !internal_clock() && count(1, at);
}

bool Timer::set_pin(bool level, Cycles at) {
  bool rose = advance_to(at);
  const bool line = clock_line(at);
  outside_ = level;
  if (!line && clock_line(at) && running() && !internal_clock() && count(1, at)) rose = true;
  return rose;
}

// If period and counter are 0, clock mode toggles every cycle.
Cycles Timer::tick_cycles() const {
  return clock_mode() && period_ == 0 && counter_ == 0 ? fast_tick_cycles : timing::timer_tick_cycles;
}

// The counter goes to 0 when it reaches the period. If it is greater than the period, it counts on through FFFFFFFFh.
std::uint64_t Timer::ticks_to_overflow() const {
  if (counter_ < period_) return period_ - counter_;
  if (counter_ == period_) return 1;
  return counter_range - counter_ + period_;
}

// Counts `ticks`, the last of them in cycle `last`; true if TSTAT went from 0 to 1.
bool Timer::count(std::uint64_t ticks, Cycles last) {
  const std::uint64_t first = ticks_to_overflow();
  if (ticks < first) {
    counter_ += static_cast<Word>(ticks);
    return false;
  }
  const std::uint64_t period = period_ == 0 ? 1 : period_, beyond = ticks - first;
  const std::uint64_t overflows = 1 + beyond / period;
  counter_ = static_cast<Word>(period_ == 0 ? 0 : beyond % period);
  const bool rises = !stuck();
  pulse_ = last - static_cast<Cycles>(beyond % period) * tick_cycles();
  if (!clock_mode()) return rises;
  const bool rose = !toggle_ || overflows >= 2;
  toggle_ ^= (overflows & 1) != 0;
  return rose;
}

Cycles Timer::next_event() const {
  if (!running() || !internal_clock()) return never_happens;
  if (stuck()) return never_happens;
  const Cycles overflow = at_ + static_cast<Cycles>(ticks_to_overflow()) * tick_cycles();
  if (!clock_mode() || !toggle_) return overflow;
  return overflow + (period_ == 0 ? fast_tick_cycles : Cycles{period_} * timing::timer_tick_cycles);
}

Cycles Timer::next_change_of_pin(Cycles last) const {
  if (!FUNC.in(control_) || !internal_clock()) return never_happens;
  if (!clock_mode() && !stuck() && pulse_ >= 0 && last <= pulse_) return pulse_ + 1;
  if (!running() || stuck()) return never_happens;
  return at_ + static_cast<Cycles>(ticks_to_overflow()) * tick_cycles();
}

bool Timer::advance_to(Cycles at) {
  if (!running() || !internal_clock() || at <= at_) return false;
  const Cycles length = tick_cycles();
  Cycles ticks = (at - at_) / length;
  const bool changes_pace = period_ == 0 && counter_ != 0 && static_cast<std::uint64_t>(ticks) >= ticks_to_overflow();
  if (changes_pace) ticks = static_cast<Cycles>(ticks_to_overflow());
  at_ += ticks * length;
  const bool rose = ticks != 0 && count(static_cast<std::uint64_t>(ticks), at_);
  return (changes_pace && advance_to(at)) || rose;
}

}  // namespace c40
