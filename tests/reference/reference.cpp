// Conditions and address updates, and the list of all operations.
#include <array>

#include "parts.hpp"

namespace reference {
namespace {

// ---- conditions: the selector counts them in the order of their codes, the reserved one left out ----

bool holds(u32 condition, u32 status) {
  const bool carry = status & flag_c, v = status & flag_v, z = status & flag_z, n = status & flag_n,
             uf = status & flag_uf;
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
Result ldf_cond(const Case& c) {
  return {holds(c.selector, c.status) ? (c.a >> 32 == 0x80 ? u64{0x80} << 32 : c.a) : c.d, c.status};
}

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

std::vector<Operation> condition_and_address_operations() {
  constexpr auto floats = Operands::floats, words = Operands::words, address = Operands::address;
  return {
      {"ldfcond", floats, 20, ldf_cond},          {"ldicond", words, 20, ldi_cond},
      {"circular_up", address, 1, circular_up},   {"circular_down", address, 1, circular_down},
      {"bit_reversed", address, 1, bit_reversed},
  };
}

const std::vector<Operation>& operations() {
  static const std::vector<Operation> all = [] {
    std::vector<Operation> out = float_operations();
    for (const auto& more : {integer_operations(), condition_and_address_operations()})
      out.insert(out.end(), more.begin(), more.end());
    return out;
  }();
  return all;
}

}  // namespace reference
