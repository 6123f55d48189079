// Numbers in the C40's single format, for the job areas.
#include "cmrc/tasks/ti_float.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <initializer_list>

namespace {

/// The value of a word, by the definition of the format (c40-isa.md): not the code under test.
double by_definition(std::uint32_t word) {
  const int exponent = static_cast<int>(word >> 24) - (word >> 31 != 0 ? 256 : 0);
  if (exponent == -128) return 0;
  return ((word >> 23 & 1) != 0 ? -2 + (word & 0x7FFFFF) / 8388608.0 : 1 + (word & 0x7FFFFF) / 8388608.0) *
         std::pow(2.0, exponent);
}

}  // namespace

TEST_CASE("numbers within half a place of their last bit") {
  for (const double value :
       {0.0, 1.0, -1.0, -2.0, 0.5, -0.5, 1.5, -1.5, 3.141592653589793, -123456.789, 1e-30, -1e30, 0x1p-127}) {
    CAPTURE(value);
    CHECK(std::abs(by_definition(cmrc::ti_float(value)) - value) <= std::abs(value) * 0x1p-24);
  }
}

TEST_CASE("0, 1 and -1 have the manual's words") {
  CHECK(cmrc::ti_float(1) == 0x00000000);
  CHECK(cmrc::ti_float(-1) == 0xFF800000);
  CHECK(cmrc::ti_float(0) == 0x80000000);
}
