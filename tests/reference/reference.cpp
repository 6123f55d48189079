#include "reference.hpp"

#include <array>

namespace reference {
namespace {

__extension__ using Wide = __int128;
using u32 = std::uint32_t;
using u64 = std::uint64_t;
using i64 = std::int64_t;

constexpr u32 flag_c = 1, flag_v = 2, flag_z = 4, flag_n = 8, flag_uf = 16, flag_lv = 32, flag_luf = 64, flag_ovm = 128;
constexpr Wide two_to_31 = Wide{1} << 31, two_to_32 = Wide{1} << 32;
constexpr u64 zero_bits = u64{0x80} << 32;

u32 low(u64 bits) { return static_cast<u32>(bits & 0xFFFFFFFFu); }
u64 high(u64 bits) { return bits & ~u64{0xFFFFFFFFu}; }

// ---- status ----

u32 with(u32 status, bool v, bool z, bool n, bool uf) {
  status &= ~(flag_v | flag_z | flag_n | flag_uf);
  if (v) status |= flag_v | flag_lv;
  if (z) status |= flag_z;
  if (n) status |= flag_n;
  if (uf) status |= flag_uf | flag_luf;
  return status;
}

u32 with_carry(u32 status, bool carry) { return carry ? status | flag_c : status & ~flag_c; }

// ---- floats: value = m * 2^(e - 31), m = 0 or 31 bits below the leading one ----

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
  return {static_cast<u64>(e & 0xFF) << 32 | (negative ? u64{0x80000000u} : 0u) | fraction, false, false, negative, false};
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
  const i64 whole = saturates ? (x.m < 0 ? -(i64{1} << 31) : (i64{1} << 31) - 1) : static_cast<i64>(floor_shift(x.m, 31 - x.e));
  return {high(c.d) | low(static_cast<u64>(whole)), with(c.status, saturates, whole == 0, whole < 0, false)};
}

i64 as_signed(u64 bits) {
  const i64 word = static_cast<i64>(low(bits));
  return word >= i64{1} << 31 ? word - (i64{1} << 32) : word;
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
        root[p][i] = largest([&](u64 v) { return (2 * v - 1) * (2 * v - 1) * (middle << p) <= u64{4} * 512 * 512 * 512; });
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

Result saturated_seed(const Case& c) { return {u64{0x7F} << 32 | 0x7FFFFFFFu, with(c.status, true, false, false, false)}; }

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
  return float_result(c, settle(-q - 1, static_cast<Wide>(seeds().root[static_cast<std::size_t>(p)][y.fraction >> 23]) << 23));
}

// ---- integers ----

/// A true result: `carry` 0, 1, or -1 where C stays.
Result integer_result(const Case& c, i64 exact, int carry, bool saturates = true) {
  constexpr i64 least = -(i64{1} << 31), most = (i64{1} << 31) - 1;
  const bool overflow = exact < least || exact > most;
  i64 written = exact;
  if (overflow && saturates && (c.status & flag_ovm) != 0) written = exact < 0 ? least : most;
  const u32 word = low(static_cast<u64>(written));
  u32 status = with(c.status, overflow, word == 0, exact < 0, false);
  if (carry >= 0) status = with_carry(status, carry != 0);
  return {high(c.d) | word, status};
}

Result add(const Case& c, u64 a, u64 b, u32 carry) {
  return integer_result(c, as_signed(a) + as_signed(b) + carry, (u64{low(a)} + low(b) + carry) > 0xFFFFFFFFu);
}
Result subtract(const Case& c, u64 a, u64 b, u32 borrow, bool saturates = true) {
  return integer_result(c, as_signed(a) - as_signed(b) - borrow, u64{low(a)} < u64{low(b)} + borrow, saturates);
}

Result addi(const Case& c) { return add(c, c.a, c.b, 0); }
Result addc(const Case& c) { return add(c, c.a, c.b, c.status & flag_c); }
Result subi(const Case& c) { return subtract(c, c.a, c.b, 0); }
Result subb(const Case& c) { return subtract(c, c.a, c.b, c.status & flag_c); }
Result subri(const Case& c) { return subtract(c, c.a, c.d, 0); }
Result subrb(const Case& c) { return subtract(c, c.a, c.d, c.status & flag_c); }
Result negi(const Case& c) { return subtract(c, 0, c.a, 0); }
Result negb(const Case& c) { return subtract(c, 0, c.a, c.status & flag_c); }
Result cmpi(const Case& c) { return {c.d, subtract(c, c.a, c.b, 0, false).status}; }

Result absi(const Case& c) {
  const i64 i = as_signed(c.a);
  return integer_result(c, i < 0 ? -i : i, -1);
}
Result mpyi(const Case& c) { return integer_result(c, as_signed(c.a) * as_signed(c.b), -1); }

Result word_result(const Case& c, u32 word) {
  return {high(c.d) | word, with(c.status, false, word == 0, word >= 0x80000000u, false)};
}

Result mpyshi(const Case& c) {
  const i64 product = as_signed(c.a) * as_signed(c.b);
  return word_result(c, static_cast<u32>(static_cast<u64>(product) >> 32));
}
Result mpyuhi(const Case& c) { return word_result(c, static_cast<u32>(u64{low(c.a)} * low(c.b) >> 32)); }

Result and_(const Case& c) { return word_result(c, low(c.a & c.b)); }
Result andn(const Case& c) { return word_result(c, low(c.a & ~c.b)); }
Result or_(const Case& c) { return word_result(c, low(c.a | c.b)); }
Result xor_(const Case& c) { return word_result(c, low(c.a ^ c.b)); }
Result not_(const Case& c) { return word_result(c, low(~c.a)); }
Result tstb(const Case& c) { return {c.d, word_result(c, low(c.a & c.b)).status}; }

// Shifts go one place at a time.

struct Bits {
  u32 word;
  bool out = false;       ///< the last bit shifted out
  bool overflow = false;  ///< the sign has changed on the way

  void left(u32 in = 0) {
    overflow = overflow || ((word >> 31 ^ word >> 30) & 1) != 0;
    out = (word & 0x80000000u) != 0;
    word = word << 1 | in;
  }
  void right(u32 in) {
    out = (word & 1) != 0;
    word = word >> 1 | in << 31;
  }
};

int count_of(u64 operand) {
  const int count = static_cast<int>(operand & 0x7F);
  return count < 64 ? count : count - 128;
}

Bits shifted(u64 operand, int count, bool keeps_sign) {
  Bits bits{low(operand)};
  for (int i = 0; i < count; ++i) bits.left();
  // Beyond 32 places C stays what it was at 32: the lowest bit.
  if (count > 32) bits.out = (operand & 1) != 0;
  for (int i = 0; i > count; --i) bits.right(keeps_sign ? bits.word >> 31 : 0);
  if (count < 0) bits.overflow = false;
  return bits;
}

Result lsh(const Case& c) {
  const Bits bits = shifted(c.a, count_of(c.b), false);
  const Result r = word_result(c, bits.word);
  return {r.d, with_carry(r.status, bits.out)};
}
Result ash(const Case& c) {
  const Bits bits = shifted(c.a, count_of(c.b), true);
  const u32 status = with(c.status, bits.overflow, bits.word == 0, bits.word >= 0x80000000u, false);
  return {high(c.d) | bits.word, with_carry(status, bits.out)};
}

Result rotated(const Case& c, bool to_left, bool through_carry) {
  Bits bits{low(c.d)};
  const u32 carry = c.status & flag_c;
  if (to_left)
    bits.left(through_carry ? carry : bits.word >> 31);
  else
    bits.right(through_carry ? carry : bits.word & 1);
  const Result r = word_result(c, bits.word);
  return {r.d, with_carry(r.status, bits.out)};
}
Result rol(const Case& c) { return rotated(c, true, false); }
Result rolc(const Case& c) { return rotated(c, true, true); }
Result ror(const Case& c) { return rotated(c, false, false); }
Result rorc(const Case& c) { return rotated(c, false, true); }

Result subc(const Case& c) {
  const u64 dividend = low(c.d), divisor = low(c.a);
  const bool fits = dividend >= divisor;
  const u64 shifted_left = (fits ? dividend - divisor : dividend) * 2 + (fits ? 1 : 0);
  return {high(c.d) | low(shifted_left), c.status};
}

// ---- part-words, by bytes ----

std::array<u32, 4> bytes_of(u64 word) {
  return {low(word) & 0xFF, low(word) >> 8 & 0xFF, low(word) >> 16 & 0xFF, low(word) >> 24};
}
u32 joined(const std::array<u32, 4>& bytes) { return bytes[0] | bytes[1] << 8 | bytes[2] << 16 | bytes[3] << 24; }
u32 sign_fill(u32 value, unsigned width) { return (value >> (width - 1) & 1) != 0 ? value | ~u32{0} << width : value; }

Result lbu(const Case& c) { return word_result(c, bytes_of(c.a)[c.selector]); }
Result lb(const Case& c) { return word_result(c, sign_fill(bytes_of(c.a)[c.selector], 8)); }
u32 half_of(const Case& c) { return bytes_of(c.a)[2 * c.selector] | bytes_of(c.a)[2 * c.selector + 1] << 8; }
Result lhu(const Case& c) { return word_result(c, half_of(c)); }
Result lh(const Case& c) { return word_result(c, sign_fill(half_of(c), 16)); }

Result lwl(const Case& c) {
  std::array<u32, 4> out = bytes_of(c.d);
  for (u32 i = c.selector; i < 4; ++i) out[i] = bytes_of(c.a)[i - c.selector];
  return word_result(c, joined(out));
}
Result lwr(const Case& c) {
  std::array<u32, 4> out = bytes_of(c.d);
  for (u32 i = c.selector; i < 4; ++i) out[i - c.selector] = bytes_of(c.a)[i];
  return word_result(c, joined(out));
}
Result mb(const Case& c) {
  std::array<u32, 4> out = bytes_of(c.d);
  out[c.selector] = bytes_of(c.a)[0];
  return word_result(c, joined(out));
}
Result mh(const Case& c) {
  std::array<u32, 4> out = bytes_of(c.d);
  out[2 * c.selector] = bytes_of(c.a)[0];
  out[2 * c.selector + 1] = bytes_of(c.a)[1];
  return word_result(c, joined(out));
}

// ---- conditions: the selector counts them in the order of their codes, the reserved one left out ----

bool holds(u32 condition, u32 status) {
  const bool carry = status & flag_c, v = status & flag_v, z = status & flag_z, n = status & flag_n, uf = status & flag_uf;
  const std::array<bool, 20> all{true,
                                 carry,
                                 carry || z,
                                 !(carry || z),
                                 !carry,
                                 z,
                                 !z,
                                 n,
                                 n || z,
                                 !(n || z),
                                 !n,
                                 !v,
                                 v,
                                 !uf,
                                 uf,
                                 (status & flag_lv) == 0,
                                 (status & flag_lv) != 0,
                                 (status & flag_luf) == 0,
                                 (status & flag_luf) != 0,
                                 z || uf};
  return all[condition];
}
Result ldi_cond(const Case& c) { return {holds(c.selector, c.status) ? high(c.d) | low(c.a) : c.d, c.status}; }
Result ldf_cond(const Case& c) { return {holds(c.selector, c.status) ? canonical(c.a) : c.d, c.status}; }

// ---- address updates: a the address, b the step, d the block size ----

Result circular(const Case& c, bool up) {
  const i64 size = low(c.d), step = low(c.b);
  i64 span = 1;
  while (span <= size) span *= 2;
  const i64 base = low(c.a) / span * span;
  i64 index = low(c.a) - base + (up ? step : -step);
  if (index >= size)
    index -= size;
  else if (index < 0)
    index += size;
  return {low(static_cast<u64>(base + index)), c.status};
}
Result circular_up(const Case& c) { return circular(c, true); }
Result circular_down(const Case& c) { return circular(c, false); }

Result bit_reversed(const Case& c) {
  u32 sum_bits = 0, carry = 0;
  for (int bit = 31; bit >= 0; --bit) {
    const u32 digit = (low(c.a) >> bit & 1) + (low(c.b) >> bit & 1) + carry;
    sum_bits |= (digit & 1) << bit;
    carry = digit >> 1;
  }
  return {sum_bits, c.status};
}

}  // namespace

const std::vector<Operation>& operations() {
  constexpr auto floats = Operands::floats, words = Operands::words, address = Operands::address;
  static const std::vector<Operation> all{
      {"addf", floats, 1, addf},       {"subf", floats, 1, subf},     {"cmpf", floats, 1, cmpf},
      {"mpyf", floats, 1, mpyf},       {"subrf", floats, 1, subrf},   {"negf", floats, 1, negf},
      {"absf", floats, 1, absf},       {"rnd", floats, 1, rnd},       {"fix", floats, 1, fix},
      {"norm", floats, 1, norm},       {"ldf", floats, 1, ldf},       {"lde", floats, 1, lde},
      {"ldm", floats, 1, ldm},         {"toieee", floats, 1, toieee}, {"rcpf", floats, 1, rcpf},
      {"rsqrf", floats, 1, rsqrf},     {"ldfcond", floats, 20, ldf_cond},
      {"float", words, 1, float_},     {"frieee", words, 1, frieee},  {"addi", words, 1, addi},
      {"addc", words, 1, addc},        {"subi", words, 1, subi},      {"subb", words, 1, subb},
      {"subri", words, 1, subri},      {"subrb", words, 1, subrb},    {"negi", words, 1, negi},
      {"negb", words, 1, negb},        {"absi", words, 1, absi},      {"cmpi", words, 1, cmpi},
      {"mpyi", words, 1, mpyi},        {"mpyshi", words, 1, mpyshi},  {"mpyuhi", words, 1, mpyuhi},
      {"and", words, 1, and_},         {"andn", words, 1, andn},      {"or", words, 1, or_},
      {"xor", words, 1, xor_},         {"not", words, 1, not_},       {"tstb", words, 1, tstb},
      {"lsh", words, 1, lsh},          {"ash", words, 1, ash},        {"rol", words, 1, rol},
      {"rolc", words, 1, rolc},        {"ror", words, 1, ror},        {"rorc", words, 1, rorc},
      {"subc", words, 1, subc},        {"lb", words, 4, lb},          {"lbu", words, 4, lbu},
      {"lh", words, 2, lh},            {"lhu", words, 2, lhu},        {"lwl", words, 4, lwl},
      {"lwr", words, 4, lwr},          {"mb", words, 4, mb},          {"mh", words, 2, mh},
      {"ldicond", words, 20, ldi_cond}, {"circular_up", address, 1, circular_up},
      {"circular_down", address, 1, circular_down}, {"bit_reversed", address, 1, bit_reversed},
  };
  return all;
}

}  // namespace reference
