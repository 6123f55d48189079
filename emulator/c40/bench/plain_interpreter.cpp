#include "c40/bench/plain_interpreter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <stdexcept>

namespace c40::bench {
namespace {

constexpr unsigned AR0 = 8, DP = 16, IR0 = 17, IR1 = 18, BK = 19;

}  // namespace

PlainInterpreter::PlainInterpreter() : memory_(mask + 1) {}

void PlainInterpreter::load(std::uint32_t at, const std::vector<std::uint32_t>& words) {
  for (const std::uint32_t w : words) word(at++) = w;
}

void PlainInterpreter::unknown(std::uint32_t w) const {
  throw std::runtime_error(fmt::format("the plain interpreter does not know {:08X}h at {:08X}h", w, pc_ - 1));
}

std::uint32_t PlainInterpreter::address(unsigned modn, unsigned ar, std::uint32_t step) {
  std::uint32_t& reg = r_[AR0 + ar];
  const std::uint32_t base = reg;
  if (modn == 24) return base;
  if (modn >= 8) step = r_[modn < 16 ? IR0 : IR1];
  switch (modn & 7) {
    case 0: return base + step;
    case 1: return base - step;
    case 2: return reg = base + step;
    case 3: return reg = base - step;
    case 4: reg = base + step; return base;
    case 5: reg = base - step; return base;
    default: break;
  }
  const std::uint32_t bk = r_[BK], all = bk == 0 ? 0u : ~0u >> std::countl_zero(bk);
  std::int64_t t = static_cast<std::int64_t>(base & all) + ((modn & 1) != 0 ? -std::int64_t{step} : std::int64_t{step});
  if (t >= bk)
    t -= bk;
  else if (t < 0)
    t += bk;
  reg = (base & ~all) + static_cast<std::uint32_t>(t);
  return base;
}

std::uint32_t PlainInterpreter::general_address(std::uint32_t w) {
  if ((w >> 21 & 3) == 1) return r_[DP] << 16 | (w & 0xFFFF);
  return address(w >> 11 & 31, w >> 8 & 7, w & 0xFF);
}

std::uint32_t PlainInterpreter::byte_address(std::uint32_t byte) { return address(byte >> 3 & 31, byte & 7, 1); }

std::uint32_t PlainInterpreter::general_integer(std::uint32_t w, bool zero_extended) {
  switch (w >> 21 & 3) {
    case 0: return r_[w & 31];
    case 3: return zero_extended ? w & 0xFFFF : static_cast<std::uint32_t>(static_cast<std::int16_t>(w));
    default: return word(general_address(w));
  }
}

Float40 PlainInterpreter::general_float(std::uint32_t w) {
  switch (w >> 21 & 3) {
    case 0: return float_register(w & 31);
    case 3: return float40::from_single(float40::short_to_single(w & 0xFFFF));
    default: return float40::from_single(word(general_address(w)));
  }
}

void PlainInterpreter::set_float(unsigned code, const FloatResult& result, bool flags) {
  e_[code] = result.value.e;
  r_[code] = result.value.m;
  if (!flags) return;
  v_ = (result.flags & st::V) != 0;
  uf_ = (result.flags & st::UF) != 0;
  n_ = (result.flags & st::N) != 0;
  z_ = (result.flags & st::Z) != 0;
  lv_ |= v_;
  luf_ |= uf_;
}

void PlainInterpreter::add(unsigned dst, std::uint32_t a, std::uint32_t b) {
  const std::uint32_t sum = a + b;
  r_[dst] = sum;
  if (dst >= 8 && dst < 28) return;
  c_ = sum < a;
  v_ = ((a ^ sum) & (b ^ sum)) >> 31 != 0;
  lv_ |= v_;
  n_ = (sum >> 31 != 0) != v_;
  z_ = sum == 0;
  uf_ = false;
}

void PlainInterpreter::subtract(unsigned dst, std::uint32_t a, std::uint32_t b, bool write) {
  const std::uint32_t difference = a - b;
  if (write) r_[dst] = difference;
  if (write && dst >= 8 && dst < 28) return;
  c_ = a < b;
  v_ = ((a ^ b) & (a ^ difference)) >> 31 != 0;
  lv_ |= v_;
  n_ = (difference >> 31 != 0) != v_;
  z_ = difference == 0;
  uf_ = false;
}

bool PlainInterpreter::holds(unsigned condition) const {
  switch (condition) {
    case 0: return true;
    case 5: return z_;
    case 6: return !z_;
    case 7: return n_;
    case 8: return n_ || z_;
    case 9: return !n_ && !z_;
    case 10: return !n_;
    default: throw std::runtime_error(fmt::format("the plain interpreter does not know condition {}", condition));
  }
}

void PlainInterpreter::general(std::uint32_t w) {
  const unsigned dst = w >> 16 & 31;
  const auto logic = [&](std::uint32_t value) {
    r_[dst] = value;
    if (dst >= 8 && dst < 28) return;
    n_ = value >> 31 != 0, z_ = value == 0, v_ = uf_ = false;
  };
  switch (w >> 23 & 63) {
    case 0x03: return set_float(dst, float40::add(float_register(dst), general_float(w)));
    case 0x04: return add(dst, r_[dst], general_integer(w, false));
    case 0x08: {
      const FloatResult result = float40::sub(float_register(dst), general_float(w));
      v_ = (result.flags & st::V) != 0, uf_ = (result.flags & st::UF) != 0, n_ = (result.flags & st::N) != 0,
      z_ = (result.flags & st::Z) != 0;
      lv_ |= v_, luf_ |= uf_;
      return;
    }
    case 0x09: return subtract(dst, r_[dst], general_integer(w, false), false);
    case 0x0E: return set_float(dst, float40::load(general_float(w)));
    case 0x10: return logic(general_integer(w, false));
    case 0x13: {
      const auto n = static_cast<std::int32_t>(general_integer(w, false) << 25) >> 25;
      const std::uint32_t x = r_[dst];
      if (n > 0)
        c_ = n <= 32 && (x >> (32 - n) & 1) != 0;
      else
        c_ = n < 0 && n >= -32 && (x >> (-n - 1) & 1) != 0;
      return logic(n >= 32 || n <= -32 ? 0 : n >= 0 ? x << n : x >> -n);
    }
    case 0x14: return set_float(dst, float40::mul(float_register(dst), general_float(w)));
    case 0x20: return logic(r_[dst] | general_integer(w, true));
    case 0x28: word(general_address(w)) = float40::to_single(float_register(dst)); return;
    case 0x2A: word(general_address(w)) = r_[dst]; return;
    case 0x2F: return set_float(dst, float40::sub(float_register(dst), general_float(w)));
    case 0x30: return subtract(dst, r_[dst], general_integer(w, false), true);
    default: unknown(w);
  }
}

Float40 PlainInterpreter::three_float(std::uint32_t byte, bool memory, bool type2) {
  if (!memory) return float_register(byte & 31);
  return float40::from_single(word(type2 ? r_[AR0 + (byte & 7)] + (byte >> 3 & 31) : byte_address(byte)));
}

void PlainInterpreter::three_operands(std::uint32_t w) {
  const bool type2 = (w >> 28 & 1) != 0;
  const bool first_memory = type2 ? (w >> 22 & 1) != 0 : (w >> 21 & 1) != 0,
             second_memory = type2 ? (w >> 21 & 1) != 0 : (w >> 22 & 1) != 0;
  const Float40 b = three_float(w & 0xFF, second_memory, type2);
  const Float40 a = three_float(w >> 8 & 0xFF, first_memory, type2);
  const unsigned dst = w >> 16 & 31;
  switch (w >> 23 & 31) {
    case 0x01: return set_float(dst, float40::add(a, b));
    case 0x09: return set_float(dst, float40::mul(a, b));
    case 0x0D: return set_float(dst, float40::sub(a, b));
    default: unknown(w);
  }
}

void PlainInterpreter::parallel(std::uint32_t w) {
  if (w >> 24 == 0x80 || w >> 24 == 0x81 || w >> 24 == 0x82 || w >> 24 == 0x83) {
    if ((w >> 24 & 3) != 0) unknown(w);  // P = 0: J x I beside K + H
    const Float40 i = float40::from_single(word(byte_address(w & 0xFF))),
                  j = float40::from_single(word(byte_address(w >> 8 & 0xFF)));
    const FloatResult product = float40::mul(j, i),
                      sum = float40::add(float_register(w >> 19 & 7), float_register(w >> 16 & 7));
    set_float(w >> 23 & 1, product, false);
    set_float(2 + (w >> 22 & 1), sum, false);
    v_ = ((product.flags | sum.flags) & st::V) != 0, uf_ = ((product.flags | sum.flags) & st::UF) != 0;
    lv_ |= v_, luf_ |= uf_;
    n_ = z_ = false;
    return;
  }
  const Float40 i = float40::from_single(word(byte_address(w & 0xFF))), b = float_register(w >> 19 & 7);
  const std::uint32_t to = byte_address(w >> 8 & 0xFF), stored = float40::to_single(float_register(w >> 16 & 7));
  word(to) = stored;
  switch (w >> 25 & 31) {
    case 0x06: return set_float(w >> 22 & 7, float40::add(b, i));
    case 0x0F: return set_float(w >> 22 & 7, float40::mul(b, i));
    default: unknown(w);
  }
}

// RPTS: the word is fetched once and executed `passes` times.
std::uint64_t PlainInterpreter::repeat(std::uint32_t w, std::uint64_t passes) {
  for (std::uint64_t pass = 0; pass < passes; ++pass) {
    if (w >> 30 == 3 || w >> 28 == 8)
      parallel(w);
    else if (w >> 29 == 1)
      three_operands(w);
    else
      general(w);
  }
  return passes;
}

void PlainInterpreter::run(std::uint32_t start, std::uint64_t instructions) {
  pc_ = start;
  unsigned slots = 0;  // until a delayed branch takes effect, itself included
  std::uint32_t delayed_target = 0;
  while (instructions > 0) {
    const std::uint32_t w = word(pc_++);
    switch (w >> 28) {
      case 0x0:
      case 0x1:
        if ((w >> 23 & 63) == 0x27)
          instructions -= repeat(word(pc_++), std::min<std::uint64_t>(instructions - 1, general_integer(w, true) + 1));
        else
          general(w);
        break;
      case 0x2:
      case 0x3: three_operands(w); break;
      case 0x4:
        if (const Float40 value = general_float(w); holds(w >> 23 & 31))
          set_float(w >> 16 & 31, {float40::canonical(value), 0}, false);
        break;
      case 0x6:
        if (w >> 24 == 0x6A && (w >> 21 & 7) == 0) {
          if (holds(w >> 16 & 31)) pc_ += static_cast<std::uint32_t>(static_cast<std::int16_t>(w));
        } else if (w >> 25 == 0x37) {
          std::uint32_t& counter = r_[AR0 + (w >> 22 & 7)];
          const bool wanted = holds(w >> 16 & 31), delayed = (w >> 21 & 1) != 0;
          if (static_cast<std::int32_t>(--counter) >= 0 && wanted) {
            const std::uint32_t target = pc_ + static_cast<std::uint32_t>(static_cast<std::int16_t>(w));
            if (delayed)
              slots = 4, delayed_target = target + 2;
            else
              pc_ = target;
          }
        } else {
          unknown(w);
        }
        break;
      case 0x8:
      case 0xC:
      case 0xD: parallel(w); break;
      default: unknown(w);
    }
    if (slots != 0 && --slots == 0) pc_ = delayed_target;
    --instructions;
  }
}

}  // namespace c40::bench
