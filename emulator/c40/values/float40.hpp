#pragma once
/// The C40's floating point, bit for bit, in integers only (c40-isa.md 2.2, 7.1 to 7.7, 7.10).
///
/// A number is (e, m): e the signed exponent of bits 39..32, m the bits 31..0. Its value is M * 2^(e-31) with M =
/// sign_extend(m) XOR 2^31, a 33-bit two's complement mantissa; e = -128 means zero whatever m is. Every operation
/// returns its value and the flags V, Z, N, UF at their places in ST.
///
/// Functions in inner loops are always inlined: a call costs as much as the arithmetic.
///
/// Inaccuracies: the seed tables of RCPF and RSQRF are a model (the ROM's contents are not published).
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "c40/instructions/choices.hpp"

namespace c40 {

/// Bits of the status register ST (c40-isa.md 1.4).
namespace st {
inline constexpr std::uint32_t C = 1u << 0, V = 1u << 1, Z = 1u << 2, N = 1u << 3, UF = 1u << 4, LV = 1u << 5,
                               LUF = 1u << 6, OVM = 1u << 7, RM = 1u << 8, PCF = 1u << 9, CF = 1u << 10, CE = 1u << 11,
                               CC = 1u << 12, GIE = 1u << 13, PGIE = 1u << 14, SETCOND = 1u << 15;
}  // namespace st

struct Float40 {
  std::int32_t e = -128;
  std::uint32_t m = 0;
  friend bool operator==(const Float40&, const Float40&) = default;
};

struct FloatResult {
  Float40 value;
  std::uint32_t flags;
};
struct FixResult {
  std::uint32_t value;
  std::uint32_t flags;
};

namespace float40 {

inline constexpr std::int32_t zero_exponent = -128;
inline constexpr std::int64_t one = std::int64_t{1} << 31;  ///< the mantissa 1.0

constexpr Float40 zero() { return {zero_exponent, 0}; }
[[gnu::always_inline]] constexpr Float40 canonical(Float40 x) { return x.e == zero_exponent ? zero() : x; }

/// The 40 bits of a register, exponent in 39..32.
constexpr std::uint64_t bits(Float40 x) { return std::uint64_t{static_cast<std::uint8_t>(x.e)} << 32 | x.m; }
constexpr Float40 from_bits(std::uint64_t bits) {
  return {static_cast<std::int8_t>(bits >> 32), static_cast<std::uint32_t>(bits)};
}

/// A memory word unchanged: the mantissa is kept even if the exponent is that of zero (NORM, POPF).
constexpr Float40 from_single_raw(std::uint32_t word) { return {static_cast<std::int8_t>(word >> 24), word << 8}; }
[[gnu::always_inline]] constexpr Float40 from_single(std::uint32_t word) { return canonical(from_single_raw(word)); }
/// The value that STF stores: bits 39..8, truncated.
constexpr std::uint32_t to_single(Float40 x) { return static_cast<std::uint32_t>(x.e) << 24 | x.m >> 8; }

/// A 16-bit short float as the memory word of the same value; e = -8 is zero.
constexpr std::uint32_t short_to_single(std::uint32_t half) {
  const auto e = static_cast<std::int32_t>(half << 16) >> 28;
  if (e == -8) return 0x80000000u;
  return static_cast<std::uint32_t>(e) << 24 | (half & 0xFFFu) << 12;
}

/// The 33-bit mantissa, scaled by 2^31; 0 for zero.
[[gnu::always_inline]] constexpr std::int64_t mantissa(Float40 x) {
  const std::int64_t m = static_cast<std::int64_t>(static_cast<std::int32_t>(x.m)) ^ one;
  return x.e == zero_exponent ? 0 : m;
}
/// Exact.
inline double to_double(Float40 x) { return std::ldexp(static_cast<double>(mantissa(x)), x.e - 31); }
[[gnu::always_inline]] constexpr Float40 pack(std::int32_t e, std::int64_t m) {
  return {e, static_cast<std::uint32_t>(m) ^ 0x80000000u};
}

/// c40-isa.md 7.1 for a normalised, non-zero mantissa.
[[gnu::always_inline]] constexpr FloatResult finish(std::int32_t e, std::int64_t m) {
  const std::uint32_t sign = m < 0 ? st::N : 0u;
  if (static_cast<std::uint32_t>(e + 127) <= 254u) [[likely]]
    return {pack(e, m), sign};
  if (e > 127) return {{127, m > 0 ? 0x7FFFFFFFu : 0x80000000u}, sign | st::V};
  return {zero(), sign | st::UF};
}

/// The number of bits of s without its sign: 0 for 0 and -1, 32 for a normalised mantissa.
[[gnu::always_inline]] constexpr int significant_bits(std::int64_t s) {
  const auto magnitude = static_cast<std::uint64_t>(s ^ (s >> 63));
  return std::countl_zero(magnitude << 1 | 1u) ^ 63;
}
/// Shifts s, which has `bits` significant bits, so that it has 32: floor.
[[gnu::always_inline]] constexpr std::int64_t with_32_bits(std::int64_t s, int bits) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(s) << (34 - bits)) >> 2;
}

/// Normalises any non-zero |s| < 2^35 (a right shift by at most 2, floor, or a left shift) and finishes.
[[gnu::always_inline]] constexpr FloatResult normalise(std::int32_t e, std::int64_t s) {
  const int bits = significant_bits(s);
  return finish(e + bits - 32, with_32_bits(s, bits));
}

constexpr FloatResult exact_zero() { return {zero(), st::Z}; }

/// c40-isa.md 7.2. Both mantissas are aligned (floor, all bits kept) before they are added or subtracted.
template <bool subtract>
[[gnu::always_inline]] constexpr FloatResult add_aligned(Float40 a, Float40 b) {
  const std::int32_t e = a.e > b.e ? a.e : b.e;
  const std::int32_t da = e - a.e, db = e - b.e;
  const std::int64_t ma = mantissa(a) >> (da > 63 ? 63 : da);
  const std::int64_t mb = mantissa(b) >> (db > 63 ? 63 : db);
  const std::int64_t s = subtract ? ma - mb : ma + mb;
  if (s == 0) [[unlikely]]
    return exact_zero();
  return normalise(e, s);
}
[[gnu::always_inline]] constexpr FloatResult add(Float40 a, Float40 b) { return add_aligned<false>(a, b); }
[[gnu::always_inline]] constexpr FloatResult sub(Float40 a, Float40 b) { return add_aligned<true>(a, b); }

/// c40-isa.md 7.3: 32-bit mantissas, truncated.
[[gnu::always_inline]] constexpr FloatResult mul(Float40 a, Float40 b) {
  __extension__ using Int128 = __int128;
  const Int128 p = static_cast<Int128>(mantissa(a)) * mantissa(b);
  const auto s = static_cast<std::int64_t>(p >> 31);
  if (s == 0) [[unlikely]]
    return exact_zero();
  return normalise(a.e + b.e, s);
}

/// The product of two memory words before it is normalised; s = 0 for zero.
struct SingleProduct {
  std::int32_t e;
  std::int64_t s;
};
/// The mantissas of words are those of registers shifted down by 8 bits, so the full product shifted down by 31 is this
/// product shifted down by 15.
[[gnu::always_inline]] constexpr SingleProduct product_of_singles(std::uint32_t a, std::uint32_t b) {
  constexpr std::int32_t hidden = 1 << 23;
  const std::int32_t ea = static_cast<std::int32_t>(a) >> 24, eb = static_cast<std::int32_t>(b) >> 24;
  if (ea == zero_exponent || eb == zero_exponent) [[unlikely]]
    return {zero_exponent, 0};
  const std::int64_t ma = (static_cast<std::int32_t>(a << 8) >> 8) ^ hidden,
                     mb = (static_cast<std::int32_t>(b << 8) >> 8) ^ hidden;
  return {ea + eb, ma * mb >> 15};
}
/// c40-isa.md 7.3 for two memory words.
[[gnu::always_inline]] constexpr FloatResult mul_singles(std::uint32_t a, std::uint32_t b) {
  const SingleProduct p = product_of_singles(a, b);
  return p.s == 0 ? exact_zero() : normalise(p.e, p.s);
}

/// c40-isa.md 7.6. NEGF is exactly 0 - x.
constexpr FloatResult neg(Float40 x) {
  const std::int64_t m = mantissa(x);
  return m == 0 ? exact_zero() : normalise(x.e, -m);
}
constexpr FloatResult abs(Float40 x) {
  const std::int64_t m = mantissa(x);
  if (m == 0) return exact_zero();
  return m > 0 ? FloatResult{x, 0} : normalise(x.e, -m);
}

/// c40-isa.md 5.3 class G: a load's flags.
constexpr FloatResult load(Float40 x) {
  const Float40 value = canonical(x);
  return {value, value.e == zero_exponent ? st::Z : (value.m >> 31) * st::N};
}

/// c40-isa.md 7.4: rounds to single precision; a half goes to the more positive neighbour. Z is always cleared; RND of
/// zero sets UF.
constexpr FloatResult rnd(Float40 x) {
  const std::int64_t m = mantissa(x);
  if (m == 0) return {zero(), st::UF};
  FloatResult r = normalise(x.e, m + 0x80);
  r.value.m &= 0xFFFFFF00u;  // after an overflow too: the result is the greatest single
  return r;
}

/// c40-isa.md 7.5: floor; saturates for either value of OVM.
constexpr FixResult fix(Float40 x) {
  const std::int64_t m = mantissa(x);
  const std::uint32_t sign = m < 0 ? st::N : 0u;
  if (x.e > 30) return {m < 0 ? 0x80000000u : 0x7FFFFFFFu, sign | st::V};
  const std::int32_t shift = 31 - x.e;
  const auto value = static_cast<std::uint32_t>(m >> (shift > 63 ? 63 : shift));
  return {value, sign | (value == 0 ? st::Z : 0u)};
}

constexpr FloatResult from_integer(std::uint32_t word) {
  if (word == 0) return exact_zero();
  return normalise(31, static_cast<std::int32_t>(word));
}

/// c40-isa.md 7.7: m has no implied bit here.
constexpr FloatResult norm(Float40 x) {
  if (x.m == 0) return exact_zero();
  const std::uint32_t sign = (x.m >> 31) * st::N;
  if (x.e == zero_exponent) return {zero(), st::UF | sign};
  const std::uint32_t redundant = x.m ^ (x.m >> 31 ? 0xFFFFFFFFu : 0u);
  const int k = std::countl_zero(redundant);  // 1 to 32
  const std::int32_t e = x.e - k;
  if (e < -127) return {zero(), st::UF | sign};
  const auto shifted = static_cast<std::uint32_t>(std::uint64_t{x.m} << k);
  return {{e, shifted ^ 0x80000000u}, sign};
}

/// c40-isa.md 2.3. The IEEE word is in bits 39..8 of the result.
constexpr FloatResult to_ieee(Float40 x) {
  if (choices::toieee_rounds && x.e != zero_exponent) x = rnd(x).value;
  const std::uint32_t negative = x.m >> 31, f = x.m >> 8 & 0x7FFFFFu;
  if (x.e == zero_exponent) return {from_single_raw(0), st::Z};
  if (x.e == -127) return {from_single_raw(0), st::Z | st::UF | negative * st::N};
  const auto exponent = static_cast<std::uint32_t>(x.e + 127);
  if (!negative) return {from_single_raw(exponent << 23 | f), 0};
  if (f != 0) return {from_single_raw(0x80000000u | exponent << 23 | ((0u - f) & 0x7FFFFFu)), st::N};
  return {from_single_raw(0x80000000u | (exponent + 1) << 23), st::N | (x.e == 127 ? st::V : 0u)};
}

constexpr FloatResult from_ieee(std::uint32_t word) {
  const std::uint32_t exponent = word >> 23 & 0xFFu, f = word & 0x7FFFFFu;
  const bool negative = word >> 31 != 0;
  if (exponent == 255)
    return {{127, negative ? 0x80000000u : 0x7FFFFF00u | choices::frieee_saturated_low_bits},
            st::V | (negative ? st::N : 0u)};
  if (exponent == 0) return {zero(), st::Z | (f != 0 ? st::UF : 0u)};
  const auto e = static_cast<std::int32_t>(exponent) - 127;
  if (!negative) return {{e, f << 8}, 0};
  if (f != 0) return {{e, 0x80000000u | ((0u - f) & 0x7FFFFFu) << 8}, st::N};
  return load({e - 1, 0x80000000u});
}

/// round(2 / x) for x = 1 + (i + 1/2) / 256, as eight fraction bits.
constexpr std::uint32_t reciprocal_seed(std::uint32_t i) {
  const std::uint32_t d = 513 + 2 * i;
  const std::uint32_t f = (512 * (511 - 2 * i) + d) / (2 * d);
  return f > 255 ? 255 : f;
}

/// RCPF and RSQRF of zero.
constexpr FloatResult seed_of_zero() { return {{127, 0x7FFFFFFFu}, st::V}; }

/// c40-isa.md 7.10, our model of the seed: the exponent is exact, eight fraction bits from a table.
constexpr FloatResult rcp(Float40 x) {
  std::int64_t m = mantissa(x);
  if (m == 0) return seed_of_zero();
  std::int32_t e = x.e;
  const bool negative = m < 0;
  if (negative) {
    m = -m;
    if (m == 2 * one) m = one, ++e;
  }
  const auto fraction = static_cast<std::uint32_t>(m - one);
  std::int64_t r = one;
  if (fraction == 0) {
    e = -e;
  } else {
    r += std::int64_t{reciprocal_seed(fraction >> 23)} << 23;
    e = -e - 1;
  }
  return normalise(e, negative ? -r : r);
}

/// round(2 / sqrt(2^p * (1 + (i + 1/2) / 256))) as eight fraction bits, index p * 256 + i.
constexpr std::array<std::uint8_t, 512> root_seeds = [] {
  std::array<std::uint8_t, 512> table{};
  for (std::uint64_t p = 0; p < 2; ++p)
    for (std::uint64_t i = 0; i < 256; ++i) {
      const std::uint64_t d = (513 + 2 * i) << p;
      std::uint64_t v = 256;
      while (v < 511 && (2 * v + 1) * (2 * v + 1) * d <= 4ull * 512 * 512 * 512) ++v;
      table[p * 256 + i] = static_cast<std::uint8_t>(v - 256);
    }
  return table;
}();

/// The root of the magnitude: the chip's result for a negative operand is not known.
constexpr FloatResult rsqr(Float40 x) {
  std::int64_t m = mantissa(x);
  if (m == 0) return seed_of_zero();
  std::int32_t e = x.e;
  if (m < 0) {
    m = -m;
    if (m == 2 * one) m = one, ++e;
  }
  const auto fraction = static_cast<std::uint32_t>(m - one);
  const std::int32_t p = e & 1, q = e >> 1;
  if (p == 0 && fraction == 0) return finish(-q, one);
  const std::int64_t seed = root_seeds[static_cast<std::uint32_t>(p) * 256 + (fraction >> 23)];
  return finish(-q - 1, one + (seed << 23));
}

}  // namespace float40
}  // namespace c40
