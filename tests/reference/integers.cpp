// Integers: true results in 64 bits; shifts one place at a time; part-words byte by byte.
#include "parts.hpp"

#include <array>

namespace reference {
namespace {

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

}  // namespace

std::vector<Operation> integer_operations() {
  constexpr auto words = Operands::words;
  return {
      {"addi", words, 1, addi},     {"addc", words, 1, addc},   {"subi", words, 1, subi}, {"subb", words, 1, subb},
      {"subri", words, 1, subri},   {"subrb", words, 1, subrb}, {"negi", words, 1, negi}, {"negb", words, 1, negb},
      {"absi", words, 1, absi},     {"cmpi", words, 1, cmpi},   {"mpyi", words, 1, mpyi}, {"mpyshi", words, 1, mpyshi},
      {"mpyuhi", words, 1, mpyuhi}, {"and", words, 1, and_},    {"andn", words, 1, andn}, {"or", words, 1, or_},
      {"xor", words, 1, xor_},      {"not", words, 1, not_},    {"tstb", words, 1, tstb}, {"lsh", words, 1, lsh},
      {"ash", words, 1, ash},       {"rol", words, 1, rol},     {"rolc", words, 1, rolc}, {"ror", words, 1, ror},
      {"rorc", words, 1, rorc},     {"subc", words, 1, subc},   {"lb", words, 4, lb},     {"lbu", words, 4, lbu},
      {"lh", words, 2, lh},         {"lhu", words, 2, lhu},     {"lwl", words, 4, lwl},   {"lwr", words, 4, lwr},
      {"mb", words, 4, mb},         {"mh", words, 2, mh},
  };
}

}  // namespace reference
