// Times of events in bounded memory (docs/report.md, Long runs); picoseconds.
#include "cmrc/measures/event_times.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <random>
#include <vector>

namespace {

using cmrc::Time;
constexpr std::int64_t ms = 1'000'000'000;

}  // namespace

TEST_CASE("instants are kept as they are while there are few") {
  cmrc::EventTimes instants(4, 100);
  for (const std::int64_t at : {7, 3, 5, 9}) instants.add(Time{at * ms + 1});
  CHECK(instants.bin().count() == 0);
  const auto kept = instants.in_order();
  REQUIRE(kept.size() == 4);
  for (std::size_t n = 0; n < 4; ++n) {
    CHECK(kept[n].time.count() == (3 + 2 * static_cast<std::int64_t>(n)) * ms + 1);
    CHECK(kept[n].count == 1);
  }
  CHECK(instants.until(Time{3 * ms}) == 0);
  CHECK(instants.until(Time{3 * ms + 1}) == 1);
  CHECK(instants.until(Time{8 * ms}) == 3);
  CHECK(instants.until(Time{10 * ms}) == 4);
}

TEST_CASE("many instants are counted in bins that double") {
  std::mt19937_64 draw(1);
  cmrc::EventTimes instants(100, 64);
  std::vector<std::int64_t> times;
  for (std::int64_t i = 0; i < 3000; ++i) {
    times.push_back(i * ms / 3 + std::uniform_int_distribution<std::int64_t>(0, ms / 3 - 1)(draw));
    instants.add(Time{times.back()});
    CHECK(instants.count() == times.size());
  }
  const std::int64_t bin = instants.bin().count();
  CHECK(bin == 16 * ms);  // 64 bins of 16 ms hold 1000 ms, 64 of 8 ms do not
  std::map<std::int64_t, std::uint64_t> expected, found;
  for (const std::int64_t time : times) ++expected[time / bin * bin];
  for (const auto& some : instants.in_order()) found[some.time.count()] += some.count;
  CHECK(found.size() <= 64);
  CHECK(found == expected);
  for (std::int64_t edge = 0; edge < 1000 * ms; edge += bin) {
    CHECK(instants.until(Time{edge}) ==
          static_cast<std::uint64_t>(std::ranges::count_if(times, [&](std::int64_t t) { return t < edge; })));
  }
  CHECK(instants.until(Time{std::ranges::max(times)}) == times.size());
}
