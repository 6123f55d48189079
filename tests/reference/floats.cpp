// Floats: value = m * 2^(e - 31), m = 0 or 31 bits below the leading one.
#include <array>

#include "parts.hpp"

namespace reference {
namespace {

constexpr Wide two_to_31 = Wide{1} << 31, two_to_32 = Wide{1} << 32;
constexpr u64 zero_bits = u64{0x80} << 32;

struct Number {
  int e;
  Wide m;
};

Number unpack(u64 bits) {
  int e = static_cast<int>(bits >> 32);
  if (e >= 128) e -= 256;
  const Wide fraction = static_cast<Wide>(bits & 0x7FFFFFFFu);
  if (e == -128) return {e, 0};
  return {e, ((bits >> 31 & 1) != 0 ? -two_to_32 : two_to_31) + fraction};
}

bool is_too_big(Wide m) { return m >= two_to_32 || m < -two_to_32; }
bool is_too_small(Wide m) { return m < two_to_31 && m >= -two_to_31; }

struct Rounded {
  u64 bits;
  bool v, z, n, uf;
};

/// Any m, exactly or floored to 32 bits of mantissa.
Rounded settle(int e, Wide m) {
  if (m == 0) return {zero_bits, false, true, false, false};
  const bool negative = m < 0;
  while (is_too_big(m)) m >>= 1, ++e;
  while (is_too_small(m)) m *= 2, --e;
  if (e > 127) return {(u64{127} << 32) | (negative ? 0x80000000u : 0x7FFFFFFFu), true, false, negative, false};
  if (e < -127) return {zero_bits, false, false, negative, true};
  const u64 fraction = static_cast<u64>(m - (negative ? -two_to_32 : two_to_31));
  return {static_cast<u64>(e & 0xFF) << 32 | (negative ? u64{0x80000000u} : 0u) | fraction, false, false, negative,
          false};
}

Result float_result(const Case& c, const Rounded& r) { return {r.bits, with(c.status, r.v, r.z, r.n, r.uf)}; }

Wide floor_shift(Wide m, int places) { return places > 100 ? (m < 0 ? -1 : 0) : m >> places; }

Rounded sum(u64 a, u64 b, bool negate) {
  Number x = unpack(a), y = unpack(b);
  if (x.e < y.e) {
    x.m = floor_shift(x.m, y.e - x.e);
    x.e = y.e;
  } else {
    y.m = floor_shift(y.m, x.e - y.e);
  }
  return settle(x.e, negate ? x.m - y.m : x.m + y.m);
}

Result addf(const Case& c) { return float_result(c, sum(c.a, c.b, false)); }
Result subf(const Case& c) { return float_result(c, sum(c.a, c.b, true)); }
Result subrf(const Case& c) { return float_result(c, sum(c.a, c.d, true)); }
Result cmpf(const Case& c) { return {c.d, float_result(c, sum(c.a, c.b, true)).status}; }

Result mpyf(const Case& c) {
  const Number x = unpack(c.a), y = unpack(c.b);
  return float_result(c, settle(x.e + y.e - 31, x.m * y.m));
}

Result negf(const Case& c) {
  const Number x = unpack(c.a);
  return float_result(c, settle(x.e, -x.m));
}
Result absf(const Case& c) {
  const Number x = unpack(c.a);
  return float_result(c, settle(x.e, x.m < 0 ? -x.m : x.m));
}

u64 canonical(u64 bits) { return bits >> 32 == 0x80 ? zero_bits : bits; }

Result ldf(const Case& c) {
  const u64 bits = canonical(c.a);
  const bool zero = bits == zero_bits;
  return {bits, with(c.status, false, zero, !zero && (bits >> 31 & 1) != 0, false)};
}
Result lde(const Case& c) { return {canonical(high(c.a) | low(c.d)), c.status}; }
Result ldm(const Case& c) { return {high(c.d) | low(c.a), c.status}; }

Result rnd(const Case& c) {
  const Number x = unpack(c.a);
  if (x.m == 0) return {zero_bits, with(c.status, false, false, false, true)};
  Rounded r = settle(x.e, x.m + 128);
  r.bits &= ~u64{0xFF};
  return float_result(c, r);
}

Result fix(const Case& c) {
  const Number x = unpack(c.a);
  // 30 places to the left at most, before the integer part saturates.
  const bool saturates = x.e > 30;
  const i64 whole =
      saturates ? (x.m < 0 ? -(i64{1} << 31) : (i64{1} << 31) - 1) : static_cast<i64>(floor_shift(x.m, 31 - x.e));
  return {high(c.d) | low(static_cast<u64>(whole)), with(c.status, saturates, whole == 0, whole < 0, false)};
}

Result float_(const Case& c) { return float_result(c, settle(31, as_signed(c.a))); }

Result norm(const Case& c) {
  const i64 m = as_signed(c.a);
  if (m == 0) return float_result(c, settle(0, 0));
  if (c.a >> 32 == 0x80) return {zero_bits, with(c.status, false, false, m < 0, true)};
  return float_result(c, settle(static_cast<int>(static_cast<std::int8_t>(c.a >> 32)), m));
}

// ---- IEEE ----

Result toieee(const Case& c) {
  const u32 e = low(c.a >> 32) & 0xFF, f = low(c.a) >> 8 & 0x7FFFFF;
  const bool negative = (c.a >> 31 & 1) != 0;
  if (e == 0x80) return {0, with(c.status, false, true, false, false)};
  if (e == 0x81) return {0, with(c.status, false, true, negative, true)};
  u32 biased = (e + 127) & 0xFF, fraction = f;
  if (negative && f == 0) ++biased;
  if (negative && f != 0) fraction = 0x800000 - f;
  const u64 word = u64{negative} << 31 | u64{biased} << 23 | fraction;
  return {word << 8, with(c.status, biased == 255, false, negative, false)};
}

Result frieee(const Case& c) {
  const u32 word = low(c.a), biased = word << 1 >> 24, fraction = word & 0x7FFFFF;
  const bool negative = word >= 0x80000000u;
  if (biased == 0) return {zero_bits, with(c.status, false, true, false, fraction != 0)};
  if (biased == 255)
    return {u64{0x7F} << 32 | (negative ? 0x80000000u : 0x7FFFFF00u), with(c.status, true, false, negative, false)};
  const Wide magnitude = static_cast<Wide>(0x800000u + fraction) * 256;
  return float_result(c, settle(static_cast<int>(biased) - 127, negative ? -magnitude : magnitude));
}

// ---- seeds ----

/// 256 + f8 for the middle of each of the intervals that the leading eight fraction bits name.
struct Seeds {
  std::array<u32, 256> reciprocal{};
  std::array<std::array<u32, 256>, 2> root{};

  Seeds() {
    for (u32 i = 0; i < 256; ++i) {
      const u64 middle = 513 + 2 * i;  // of 512
      reciprocal[i] = largest([&](u64 v) { return (2 * v - 1) * middle <= 2 * 512 * 512; });
      for (u32 p = 0; p < 2; ++p)
        root[p][i] =
            largest([&](u64 v) { return (2 * v - 1) * (2 * v - 1) * (middle << p) <= u64{4} * 512 * 512 * 512; });
    }
  }
  /// The greatest v with v - 1/2 not above the value that the test compares it with.
  template <typename Test>
  static u32 largest(Test not_above) {
    u32 v = 256;
    while (v < 511 && not_above(v + 1)) ++v;
    return v;
  }
};

const Seeds& seeds() {
  static const Seeds table;
  return table;
}

struct Magnitude {
  int e;
  u32 fraction;
};

Magnitude magnitude_of(Number x) {
  Wide m = x.m < 0 ? -x.m : x.m;
  if (m == two_to_32) m = two_to_31, ++x.e;
  return {x.e, static_cast<u32>(m - two_to_31)};
}

Result saturated_seed(const Case& c) {
  return {u64{0x7F} << 32 | 0x7FFFFFFFu, with(c.status, true, false, false, false)};
}

Result rcpf(const Case& c) {
  const Number x = unpack(c.a);
  if (x.m == 0) return saturated_seed(c);
  const Magnitude y = magnitude_of(x);
  const Wide m = y.fraction == 0 ? two_to_31 : static_cast<Wide>(seeds().reciprocal[y.fraction >> 23]) << 23;
  return float_result(c, settle(y.fraction == 0 ? -y.e : -y.e - 1, x.m < 0 ? -m : m));
}

Result rsqrf(const Case& c) {
  const Number x = unpack(c.a);
  if (x.m == 0) return saturated_seed(c);
  const Magnitude y = magnitude_of(x);
  const int p = (y.e + 256) % 2, q = (y.e - p) / 2;
  if (p == 0 && y.fraction == 0) return float_result(c, settle(-q, two_to_31));
  return float_result(
      c, settle(-q - 1, static_cast<Wide>(seeds().root[static_cast<std::size_t>(p)][y.fraction >> 23]) << 23));
}

}  // namespace

std::vector<Operation> float_operations() {
  constexpr auto floats = Operands::floats, words = Operands::words;
  return {
      {"addf", floats, 1, addf},   {"subf", floats, 1, subf},     {"cmpf", floats, 1, cmpf},
      {"mpyf", floats, 1, mpyf},   {"subrf", floats, 1, subrf},   {"negf", floats, 1, negf},
      {"absf", floats, 1, absf},   {"rnd", floats, 1, rnd},       {"fix", floats, 1, fix},
      {"norm", floats, 1, norm},   {"ldf", floats, 1, ldf},       {"lde", floats, 1, lde},
      {"ldm", floats, 1, ldm},     {"toieee", floats, 1, toieee}, {"rcpf", floats, 1, rcpf},
      {"rsqrf", floats, 1, rsqrf}, {"float", words, 1, float_},   {"frieee", words, 1, frieee},
  };
}

}  // namespace reference
