#pragma once
// What the parts of the reference share: bits, words and flags.

#include "reference.hpp"

namespace reference {

__extension__ using Wide = __int128;
using u32 = std::uint32_t;
using u64 = std::uint64_t;
using i64 = std::int64_t;

constexpr u32 flag_c = 1, flag_v = 2, flag_z = 4, flag_n = 8, flag_uf = 16, flag_lv = 32, flag_luf = 64, flag_ovm = 128;

inline u32 low(u64 bits) { return static_cast<u32>(bits & 0xFFFFFFFFu); }
inline u64 high(u64 bits) { return bits & ~u64{0xFFFFFFFFu}; }
inline i64 as_signed(u64 bits) {
  const i64 word = static_cast<i64>(low(bits));
  return word >= i64{1} << 31 ? word - (i64{1} << 32) : word;
}

inline u32 with(u32 status, bool v, bool z, bool n, bool uf) {
  status &= ~(flag_v | flag_z | flag_n | flag_uf);
  if (v) status |= flag_v | flag_lv;
  if (z) status |= flag_z;
  if (n) status |= flag_n;
  if (uf) status |= flag_uf | flag_luf;
  return status;
}
inline u32 with_carry(u32 status, bool carry) { return carry ? status | flag_c : status & ~flag_c; }

std::vector<Operation> float_operations();
std::vector<Operation> integer_operations();
std::vector<Operation> condition_and_address_operations();

}  // namespace reference
