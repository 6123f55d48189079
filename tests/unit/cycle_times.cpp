// The time of runs by cause.
#include "cmrc/measures/cycle_times.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace {

using cmrc::ChainTimes;
using Times = std::vector<std::int64_t>;

const ChainTimes& times() {  // a clock of 25 MHz: 40 ns a cycle
  static const ChainTimes made({"execute", "memory"}, machine::Clock(25'000'000));
  return made;
}

}  // namespace

TEST_CASE("an ended run at the nominal clock is divided by its cycles") {
  CHECK(times().causes() == std::vector<std::string>{"execute", "memory", "slow_clock", "unknown"});
  CHECK(times().of({3, 1}, 160'000, true) == Times{120'000, 40'000, 0, 0});
}

TEST_CASE("what an ended run took beyond its cycles at the nominal clock is the slowed clock's") {
  CHECK(times().of({3, 1}, 200'000, true) == Times{120'000, 40'000, 40'000, 0});
}

TEST_CASE("a run under way has no slowed clock, since its clock may still change") {
  CHECK(times().of({3, 1}, 200'000, false) == Times{150'000, 50'000, 0, 0});
}

TEST_CASE("a run whose counters are not known is unknown, however long it was") {
  for (const bool ended : {false, true})
    for (const std::int64_t whole : {0, 1, 2, 160'000}) CHECK(times().of({}, whole, ended) == Times{0, 0, 0, whole});
}
