// May-load tokens (plant-and-bus.md 4.4, items 13 to 16).
#include "cmrc/processes/consents.hpp"

#include <doctest/doctest.h>

namespace {

cmrc::Consents consents_of(unsigned agvs) { return {cmrc::built_in_processes(), agvs}; }

}  // namespace

TEST_CASE("a process starts only when all have consented") {
  cmrc::Consents consents = consents_of(2);
  constexpr unsigned rows[][3] = {{2, 4, 3}, {3, 6, 4}, {1, 4, 7}};
  for (const auto& [first, second, target] : rows) {
    consents.give(first, target);
    CHECK_FALSE(consents.all(target));
    consents.give(second, target);
    CHECK(consents.all(target));
  }
}

TEST_CASE("a consent is a one-place token") {
  cmrc::Consents consents = consents_of(1);
  consents.give(2, 3);
  consents.give(2, 3);
  consents.give(4, 3);
  consents.consume(3);
  CHECK_FALSE(consents.given(2, 3));
}

TEST_CASE("consents of an AGV are its own, and the end of the job is everybody's") {
  cmrc::Consents consents = consents_of(2);
  consents.give(6, 4, 1);
  consents.give(3, 4);
  CHECK_FALSE(consents.all(4, 0));
  CHECK(consents.all(4, 1));
  consents.give(1, 8);
  consents.give(4, 8);  // nothing hangs on the crane
  consents.give(5, 8, 0);
  consents.give(5, 8, 1);
  consents.consume(8, 0);
  CHECK_FALSE(consents.all(8, 0));
  CHECK(consents.all(8, 1));
  consents.clear(4, 8);
  CHECK_FALSE(consents.all(8, 1));
}
