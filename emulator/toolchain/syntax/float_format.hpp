#pragma once
// Decimal numbers to the TMS320C4x float formats (c40-isa.md 2.2), rounded to nearest, ties away from zero.
#include <cstdint>
#include <optional>
#include <string_view>

#include "isa/word.hpp"

namespace toolchain {

/// A number that may differ a little from its nearest double, as most decimals do.
struct Real {
  double nearest = 0;
  int residue = 0;  ///< Sign of (exact value - nearest).

  Real() = default;
  Real(double value) : nearest(value) {}  // NOLINT: a double is a Real
  Real(double value, int sign) : nearest(value), residue(sign) {}
  Real operator-() const { return {-nearest, -residue}; }
};

Real real_of(std::int64_t number);

/// "1.5", "2e-3", ".5"; none if the text is no number. Beyond the range of double it is 0 with a residue, or
/// infinite, which no format takes.
std::optional<Real> parse_real(std::string_view text);

/// The 32-bit single format; none if the value is out of range. Values nearer to 0 than to the least number give 0.
std::optional<isa::Word> to_single(Real value);
/// The 16-bit short format of immediates.
std::optional<isa::Word> to_short(Real value);
/// The 40-bit extended format of registers R0 to R11.
std::optional<std::uint64_t> to_extended(Real value);
/// IEEE 754 single precision, rounded to nearest, ties to even.
std::optional<isa::Word> to_ieee(Real value);

}  // namespace toolchain
