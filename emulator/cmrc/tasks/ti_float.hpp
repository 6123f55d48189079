#pragma once
// The C40's single-precision format, in which the host writes numbers into the job areas.
#include <cmath>
#include <cstdint>

namespace cmrc {

/// Bits 31..24 exponent, 23 sign, 22..0 fraction, two's complement (c40-isa.md, floating-point formats); rounded to
/// nearest, saturated.
inline std::uint32_t ti_float(double value) {
  if (value == 0 || std::isnan(value)) return 0x80000000;
  int exponent = 0;
  double mantissa = std::frexp(value, &exponent);  // 0.5 <= |mantissa| < 1
  --exponent;
  mantissa *= 2;  // 1 <= |mantissa| < 2; -1 becomes -2 with the next lower exponent
  auto scaled = static_cast<std::int64_t>(std::nearbyint(mantissa * 0x800000));
  if (scaled == 0x1000000) scaled = 0x800000, ++exponent;
  if (scaled == -0x800000) scaled = -0x1000000, --exponent;
  if (exponent > 127) return value > 0 ? 0x7F7FFFFF : 0x7F800000;
  if (exponent < -127) return 0x80000000;
  // Positive: 01.fraction, the 1 is implied; negative: 10.fraction.
  const auto fraction = static_cast<std::uint32_t>(value > 0 ? scaled - 0x800000 : scaled + 0x1000000);
  return static_cast<std::uint32_t>(exponent & 0xFF) << 24 | (value < 0 ? 0x800000U : 0U) | (fraction & 0x7FFFFF);
}

/// The inverse; exact.
inline double from_ti_float(std::uint32_t word) {
  const int exponent = static_cast<std::int8_t>(word >> 24);
  if (exponent == -128) return 0;
  const double fraction = static_cast<double>(word & 0x7FFFFF) / 0x800000;
  return std::ldexp((word & 0x800000) != 0 ? fraction - 2 : fraction + 1, exponent);
}

}  // namespace cmrc
