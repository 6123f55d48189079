#pragma once
/// Virtual time (ruling 1): an integer count of picoseconds, and clocks with a rational frequency. Periods are never
/// accumulated.
#include <chrono>
#include <cstdint>
#include <numeric>
#include <ratio>
#include <stdexcept>

#include "state/visitor.hpp"

namespace c40 {

using Time = std::chrono::duration<std::int64_t, std::pico>;
using Ticks = std::int64_t;

/// Later than any event.
inline constexpr Time never = Time::max();

/// A clock of num/den hertz: tick n is at phase + floor(n * 10^12 * den / num) picoseconds, for n of either sign.
class Clock {
 public:
  /// Throws std::invalid_argument unless 0 < num/den <= 10^12 and the reduced fraction 10^12 * den / num fits (it does
  /// for every frequency given in whole hertz, or in whole hertz over a den up to 9 000 000).
  explicit constexpr Clock(std::int64_t num, std::int64_t den = 1, Time phase = Time{0}) : phase_{phase.count()} {
    if (num <= 0 || den <= 0 || den > 9'000'000)
      throw std::invalid_argument{"Clock: a frequency is a positive fraction with a denominator up to 9000000"};
    const std::int64_t above = picoseconds_per_second * den;
    const std::int64_t divisor = std::gcd(above, num);
    period_ = above / divisor;
    per_ = num / divisor;
    if (period_ < per_) throw std::invalid_argument{"Clock: faster than one tick per picosecond"};
  }

  /// The instant of a tick.
  constexpr Time at(Ticks tick) const { return per_ == 1 ? Time{phase_ + tick * period_} : at_in_fractions(tick); }

  /// The last tick at or before an instant.
  constexpr Ticks tick_at_or_before(Time time) const {
    const std::int64_t since = time.count() - phase_;
    return per_ == 1 && since >= 0 ? since / period_ : before_in_fractions(since);
  }

  /// The first tick at or after an instant.
  constexpr Ticks tick_at_or_after(Time time) const {
    const std::int64_t since = time.count() - phase_;
    return per_ == 1 && since >= 0 ? (since + period_ - 1) / period_ : after_in_fractions(since);
  }

  constexpr double hertz() const { return 1e12 * static_cast<double>(per_) / static_cast<double>(period_); }

  void list_state(state::Visitor& list) {
    list("phase", phase_);
    list("period", period_);
    list("per", per_);
  }

 private:
  __extension__ using Wide = __int128;
  static constexpr std::int64_t picoseconds_per_second = 1'000'000'000'000;

  // The general cases. Not inline, for most clocks have a period of whole picoseconds.
  [[gnu::noinline]] constexpr Time at_in_fractions(Ticks tick) const {
    return Time{phase_ + floor_divide(Wide{tick} * period_, per_)};
  }
  [[gnu::noinline]] constexpr Ticks before_in_fractions(std::int64_t since) const {
    return floor_divide((Wide{since} + 1) * per_ - 1, period_);
  }
  [[gnu::noinline]] constexpr Ticks after_in_fractions(std::int64_t since) const {
    return -floor_divide(-(Wide{since} * per_), period_);
  }

  static constexpr std::int64_t floor_divide(Wide above, std::int64_t below) {
    const Wide quotient = above / below;
    return static_cast<std::int64_t>(quotient * below > above ? quotient - 1 : quotient);
  }

  std::int64_t phase_;
  std::int64_t period_ = 1;  // period_ / per_ picoseconds between ticks, reduced
  std::int64_t per_ = 1;
};

/// The deviation of a real oscillator from its nominal frequency and phase.
struct Skew {
  std::int64_t ppm = 0;  ///< its frequency is (1 + ppm / 10^6) times the nominal one
  Time phase{0};         ///< instant of its tick 0

  /// A clock of num/den hertz with this deviation. Throws std::invalid_argument where Clock does.
  constexpr Clock clock(std::int64_t num, std::int64_t den = 1) const {
    constexpr std::int64_t million = 1'000'000;
    if (ppm == 0) return Clock{num, den, phase};
    const std::int64_t a = std::gcd(num, million), b = std::gcd(million + ppm, den);
    return Clock{num / a * ((million + ppm) / b), den / b * (million / a), phase};
  }
};

/// A clock whose frequency may change, with one continuous count of ticks.
class PacedClock {
 public:
  explicit constexpr PacedClock(Clock clock) : clock_{clock} {}
  constexpr Time at(Ticks tick) const { return clock_.at(tick - first_); }
  constexpr Ticks tick_at_or_before(Time time) const { return first_ + clock_.tick_at_or_before(time); }
  constexpr Ticks tick_at_or_after(Time time) const { return first_ + clock_.tick_at_or_after(time); }
  /// The present frequency.
  constexpr double hertz() const { return clock_.hertz(); }
  /// Whole ticks in a span of time, at the present frequency.
  constexpr Ticks ticks_in(Time span) const { return clock_.tick_at_or_before(clock_.at(0) + span); }
  /// From tick `first` on, num/den hertz. Afterwards, earlier ticks may not be asked for.
  constexpr void change(Ticks first, std::int64_t num, std::int64_t den) { change(first, Skew{}, num, den); }
  /// The same for an oscillator with a deviation of skew.ppm.
  constexpr void change(Ticks first, const Skew& skew, std::int64_t num, std::int64_t den) {
    clock_ = Skew{skew.ppm, at(first)}.clock(num, den);
    first_ = first;
  }
  void list_state(state::Visitor& list) {
    list("clock", clock_);
    list("first", first_);
  }

 private:
  Clock clock_;
  Ticks first_ = 0;
};

}  // namespace c40
