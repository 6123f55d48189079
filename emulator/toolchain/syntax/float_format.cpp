#include "toolchain/syntax/float_format.hpp"
#include "isa/ascii.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <string>

namespace toolchain {
namespace {

constexpr long endless = 1'000'000'000;  // Longer than the digits of any text.

/// 0.d1d2d3... * 10^exponent, d1 not 0; zero has no digits.
struct Decimal {
  std::string digits;
  long exponent = 0;
};

Decimal decimal_of(std::string_view text) {
  Decimal out;
  long exponent = 0;
  const auto e = text.find_first_of("eE");
  if (e != std::string_view::npos) {
    auto tail = text.substr(e + 1);
    if (!tail.empty() && tail[0] == '+') tail.remove_prefix(1);
    const auto read = std::from_chars(tail.data(), tail.data() + tail.size(), exponent);
    if (read.ec == std::errc::result_out_of_range) exponent = tail[0] == '-' ? -endless : endless;
    text = text.substr(0, e);
  }
  bool after_point = false;
  for (const char c : text) {
    if (c == '.') {
      after_point = true;
      continue;
    }
    if (out.digits.empty() && c == '0') {
      if (after_point) --exponent;
      continue;
    }
    out.digits += c;
    if (!after_point) ++exponent;
  }
  while (!out.digits.empty() && out.digits.back() == '0') out.digits.pop_back();
  out.exponent = exponent;
  return out;
}

int compare(const Decimal& a, const Decimal& b) {
  if (a.digits.empty() || b.digits.empty())
    return static_cast<int>(b.digits.empty()) - static_cast<int>(a.digits.empty());
  if (a.exponent != b.exponent) return a.exponent < b.exponent ? -1 : 1;
  const int order = a.digits.compare(b.digits);
  return (order > 0) - (order < 0);
}

/// 767 digits hold any double exactly.
Decimal exact_decimal(double value) {
  std::array<char, 800> buffer{};
  const auto [end, error] =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::scientific, 767);
  return decimal_of({buffer.data(), end});
}

/// |value| = significand * 2^(exponent - fraction_bits) with 2^fraction_bits <= significand < 2^(fraction_bits + 1).
struct Rounded {
  std::int64_t significand;
  int exponent;
};

Rounded round_magnitude(Real magnitude, int fraction_bits) {
  int exponent = 0;
  const double fraction = std::frexp(magnitude.nearest, &exponent);  // [0.5, 1)
  const auto bits = static_cast<std::int64_t>(std::ldexp(fraction, 53));
  const int dropped = 52 - fraction_bits;
  const std::int64_t half = std::int64_t{1} << (dropped - 1);
  const std::int64_t rest = bits & (2 * half - 1);
  std::int64_t significand = bits >> dropped;
  if (rest > half || (rest == half && magnitude.residue >= 0)) ++significand;
  --exponent;
  if (significand >> (fraction_bits + 1) != 0) {
    significand >>= 1;
    ++exponent;
  }
  return {significand, exponent};
}

struct FloatFormat {
  int exponent_bits;
  int fraction_bits;
  int least_exponent() const { return -(1 << (exponent_bits - 1)) + 1; }
  int greatest_exponent() const { return (1 << (exponent_bits - 1)) - 1; }
};

std::uint64_t pack(FloatFormat format, int exponent, bool negative, std::int64_t fraction) {
  const std::uint64_t exponent_field = static_cast<std::uint64_t>(exponent) & ((1U << format.exponent_bits) - 1);
  return exponent_field << (format.fraction_bits + 1) | std::uint64_t{negative} << format.fraction_bits |
         static_cast<std::uint64_t>(fraction);
}

/// Below the least exponent: the least number of that sign, or 0, whichever is nearer.
std::uint64_t tiny(FloatFormat format, Real magnitude, bool negative) {
  const double least =
      std::ldexp(1.0 + (negative ? std::ldexp(1.0, -format.fraction_bits) : 0.0), format.least_exponent());
  const double half = least / 2;
  const bool up = magnitude.nearest > half || (magnitude.nearest == half && magnitude.residue >= 0);
  if (!up) return pack(format, format.least_exponent() - 1, false, 0);
  return pack(format, format.least_exponent(), negative, negative ? (std::int64_t{1} << format.fraction_bits) - 1 : 0);
}

std::optional<std::uint64_t> convert(FloatFormat format, Real value) {
  const bool negative = std::signbit(value.nearest);
  const Real magnitude = negative ? -value : value;
  if (magnitude.nearest == 0) return pack(format, format.least_exponent() - 1, false, 0);
  if (!std::isfinite(magnitude.nearest)) return std::nullopt;
  auto [significand, exponent] = round_magnitude(magnitude, format.fraction_bits);
  const std::int64_t one = std::int64_t{1} << format.fraction_bits;
  std::int64_t fraction = significand - one;
  if (negative) {
    // A negative number has the mantissa -2 + f: -1.0 is -2.0 at the next lower exponent.
    fraction = significand == one ? 0 : 2 * one - significand;
    if (significand == one) --exponent;
  }
  if (exponent > format.greatest_exponent()) return std::nullopt;
  if (exponent < format.least_exponent()) return tiny(format, magnitude, negative);
  return pack(format, exponent, negative, fraction);
}

}  // namespace

Real real_of(std::int64_t number) {
  const auto nearest = static_cast<double>(number);
  const auto rest = static_cast<long double>(number) - static_cast<long double>(nearest);  // 64 bits hold both
  return {nearest, (rest > 0) - (rest < 0)};
}

std::optional<Real> parse_real(std::string_view text) {
  double nearest = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), nearest);
  if (end != text.data() + text.size() || error == std::errc::invalid_argument || !std::isfinite(nearest)) return {};
  if (text[0] == '-') return -*parse_real(text.substr(1));
  const Decimal decimal = decimal_of(text);
  if (error == std::errc::result_out_of_range)  // of a double, and so of all formats of the chip
    return decimal.exponent < 0 ? Real{0, 1} : Real{HUGE_VAL, 0};
  return Real{nearest, compare(decimal, exact_decimal(nearest))};
}

std::optional<isa::Word> to_single(Real value) { return convert({8, 23}, value); }
std::optional<isa::Word> to_short(Real value) { return convert({4, 11}, value); }
std::optional<std::uint64_t> to_extended(Real value) { return convert({8, 31}, value); }

std::optional<isa::Word> to_ieee(Real value) {
  const double exact = value.nearest;
  auto rounded = static_cast<float>(exact);
  if (exact != rounded && value.residue != 0) {
    // The double is exactly half-way: the residue decides.
    const float other = std::nextafter(rounded, exact > rounded ? HUGE_VALF : -HUGE_VALF);
    if (double{other} - exact == exact - double{rounded})
      rounded = value.residue > 0 ? std::max(rounded, other) : std::min(rounded, other);
  }
  if (!std::isfinite(rounded)) return std::nullopt;
  return std::bit_cast<isa::Word>(rounded);
}

}  // namespace toolchain
