// Clocks against exact rationals (ruling 1).
#include "c40/values/clock.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <initializer_list>
#include <random>
#include <stdexcept>
#include <utility>

namespace {

using c40::Clock;
using c40::Time;
__extension__ using Wide = __int128;

std::int64_t floor_of(Wide above, Wide below) {
  const Wide whole = above / below;
  return static_cast<std::int64_t>(above % below != 0 && above < 0 ? whole - 1 : whole);
}

}  // namespace

TEST_CASE("ticks stand at the floor of their exact instant") {
  constexpr std::pair<std::int64_t, std::int64_t> frequencies[] = {
      {20'000'000, 1}, {25'000'000, 1}, {30'000'000, 1}, {100'000'000, 3},    {33'333'333, 1},
      {8'000, 1},      {1, 1},          {7, 3},          {999'999'999'999, 1}};
  for (const auto& frequency : frequencies) {
    const std::int64_t num = frequency.first, den = frequency.second;
    CAPTURE(num);
    CAPTURE(den);
    std::mt19937_64 draw(static_cast<std::uint64_t>(num));
    const auto up_to = [&](std::int64_t most) { return std::uniform_int_distribution<std::int64_t>(0, most)(draw); };
    const Wide above = Wide{1'000'000'000'000} * den;
    const std::int64_t period = floor_of(above, num);
    for (const std::int64_t phase : {0, 12'345}) {
      const Clock clock(num, den, Time{phase});
      for (int i = 0; i < 300; ++i) {
        const std::int64_t tick = up_to(floor_of(Wide{400'000'000'000'000} * num, above) + 1001) - 1000;
        const std::int64_t instant = phase + floor_of(above * tick, num);
        CHECK(clock.at(tick).count() == instant);
        for (const std::int64_t at : {instant, instant - 1, instant + 1, instant + up_to(period)}) {
          const auto before = clock.tick_at_or_before(Time{at}), after = clock.tick_at_or_after(Time{at});
          CHECK(clock.at(before).count() <= at);
          CHECK(at < clock.at(before + 1).count());
          CHECK(clock.at(after).count() >= at);
          CHECK(at > clock.at(after - 1).count());
        }
      }
    }
  }
}

TEST_CASE("impossible clocks are refused") {
  CHECK_THROWS_AS(Clock(0, 1), std::invalid_argument);
  CHECK_THROWS_AS(Clock(-5, 1), std::invalid_argument);
  CHECK_THROWS_AS(Clock(5, 0), std::invalid_argument);
  CHECK_THROWS_AS(Clock(10'000'000'000'000, 1), std::invalid_argument);
}
