#include "legality.hpp"

namespace reference {
namespace {

using u32 = std::uint32_t;

u32 bits(u32 word, unsigned from, unsigned width) { return word >> from & ((1u << width) - 1); }

enum class Registers { any, extended, address };

bool may_be(Registers registers, u32 code) {
  switch (registers) {
    case Registers::any: return true;
    case Registers::extended: return code <= 7 || code >= 28;
    case Registers::address: return code >= 8 && code <= 20;
  }
  return false;
}

bool is_condition(u32 code) { return code < 21 && code != 11; }
bool is_short_indirect(u32 byte) { return byte < 26u << 3; }
bool is_long_indirect(u32 half) { return half < 8u << 11 || (half < 26u << 11 && (half & 0xFF) == 0); }

// Bit G of a set: the mode of that G. 0 is a register, 3 an immediate.
constexpr u32 direct_mode = 2, indirect_mode = 4;
constexpr u32 memory_modes = direct_mode | indirect_mode;
constexpr u32 all_modes = 15;

bool is_source(u32 word, Registers registers, u32 modes) {
  const u32 g = bits(word, 21, 2), half = bits(word, 0, 16);
  if ((modes >> g & 1) == 0) return false;
  if (g == 0) return half < 32 && may_be(registers, half);
  return g != 2 || is_long_indirect(half);
}

struct General {
  u32 modes = 0;  ///< none: not of this plain kind
  Registers source = Registers::any, destination = Registers::any;
};

General general_kind(u32 op) {
  constexpr Registers any = Registers::any, extended = Registers::extended;
  switch (op) {
    case 0:
    case 3:
    case 8:
    case 13:
    case 14:
    case 18:
    case 20:
    case 23:
    case 26:
    case 34:
    case 47:
    case 50:
    case 55:
    case 57:
    case 58: return {all_modes, extended, extended};
    case 1:
    case 2:
    case 4:
    case 5:
    case 6:
    case 7:
    case 9:
    case 16:
    case 19:
    case 21:
    case 22:
    case 24:
    case 27:
    case 32:
    case 45:
    case 46:
    case 48:
    case 49:
    case 51:
    case 52:
    case 53:
    case 59:
    case 60: return {all_modes, any, any};
    case 10: return {all_modes, extended, any};
    case 11: return {all_modes, any, extended};
    case 15:
    case 40:
    case 41:
    case 56: return {memory_modes, extended, extended};
    case 17:
    case 43:
    case 44: return {memory_modes, any, any};
    case 61: return {all_modes, any, Registers::address};
    default: return {};
  }
}

bool is_general(u32 word) {
  const u32 op = bits(word, 23, 6), g = bits(word, 21, 2), dst = bits(word, 16, 5), half = bits(word, 0, 16);
  switch (op) {
    case 12: return word == 0x06000000 || word == 0x06000001;
    case 25: return word == 0x0C800000 || (g == 2 && dst == 0 && is_long_indirect(half));
    case 28:
    case 30: return g == 1 && half == 0;
    case 29:
    case 31: return g == 1 && half == 0 && may_be(Registers::extended, dst);
    case 35:
    case 36: return g == 3 && half == 0x0001;
    case 37:
    case 38: return g == 3 && half == 0xFFFF;
    case 39: return dst == 27 && is_source(word, Registers::any, all_modes);
    case 42: return g < 2 || is_long_indirect(half);
    case 54: return dst == 0 && is_source(word, Registers::any, memory_modes);
    case 61:
      if (g == 0 && half == dst) return false;
      break;
    case 62: return g == 3 && dst == 16;
    case 63: return g == 3;
    default: break;
  }
  const General kind = general_kind(op);
  return kind.modes != 0 && is_source(word, kind.source, kind.modes) && may_be(kind.destination, dst);
}

bool is_three_operand(u32 word) {
  const u32 op = bits(word, 23, 5), t = bits(word, 21, 2), dst = bits(word, 16, 5), src1 = bits(word, 8, 8),
            src2 = bits(word, 0, 8);
  if (op > 18) return false;
  const bool is_float = op == 1 || op == 6 || op == 9 || op == 13, compares = op == 6 || op == 7 || op == 15;
  const Registers registers = is_float ? Registers::extended : Registers::any;
  const bool type2 = bits(word, 28, 1) != 0;
  // Nobody reads where compares of type 2 have no destination (docs/fidelity.md).
  if (compares ? dst != 0 && !type2 : !may_be(registers, dst)) return false;
  const auto is_register = [&](u32 byte) { return byte < 32 && may_be(registers, byte); };
  if (type2) return (t >= 2 || is_register(src1)) && (t % 2 == 1 || !is_float);
  return (t % 2 == 1 ? is_short_indirect(src1) : is_register(src1)) &&
         (t >= 2 ? is_short_indirect(src2) : is_register(src2));
}

bool is_target(u32 word) { return bits(word, 25, 1) != 0 || bits(word, 0, 16) < 32; }

bool is_control(u32 word) {
  const u32 half = bits(word, 0, 16);
  const bool conditional = is_condition(bits(word, 16, 5));
  switch (bits(word, 24, 5)) {
    case 0:
    case 1:
    case 2:
    case 3:
    case 4:
    case 5: return true;
    case 6: return word == 0x66000000;
    case 8:
    case 10: {
      const u32 kind = bits(word, 21, 3);
      return conditional && is_target(word) && (kind == 0 || kind == 1 || kind == 3 || kind == 5);
    }
    case 12:
    case 13:
    case 14:
    case 15: return conditional && is_target(word);
    case 16:
    case 18: return conditional && is_target(word) && bits(word, 22, 3) == 0;
    case 20: return conditional && bits(word, 21, 2) == 0 && half < 512;
    case 22: {
      const u32 expansion = bits(word, 23, 1) != 0 ? bits(word, 16, 5) : half;
      return bits(word, 21, 2) == 0 && half < 32 && expansion < 2;
    }
    case 24: {
      const u32 kind = bits(word, 21, 3);  // RETI, RETID, RETS
      return conditional && half == 0 && (kind == 0 || kind == 1 || kind == 4);
    }
    case 25: return bits(word, 5, 18) == 0;
    default: return false;
  }
}

bool is_pair(u32 word) {
  if (!is_short_indirect(bits(word, 8, 8)) || !is_short_indirect(bits(word, 0, 8))) return false;
  switch (bits(word, 25, 5)) {
    case 2:
    case 3: return bits(word, 16, 3) == 0;
    case 6:
    case 7:
    case 8:
    case 9:
    case 14:
    case 15:
    case 16:
    case 20:
    case 21:
    case 22:
    case 23: return true;
    case 0:
    case 1:
    case 4:
    case 5:
    case 10:
    case 11:
    case 12:
    case 13:
    case 17:
    case 18:
    case 19:
    case 24:
    case 25: return bits(word, 19, 3) == 0;
    default: return false;
  }
}

}  // namespace

bool is_instruction(u32 word) {
  switch (word >> 28) {
    case 0:
    case 1: return is_general(word);
    case 2:
    case 3: return is_three_operand(word);
    case 4:
    case 5: {
      const Registers registers = word >> 28 == 4 ? Registers::extended : Registers::any;
      return is_condition(bits(word, 23, 5)) && is_source(word, registers, all_modes) &&
             may_be(registers, bits(word, 16, 5));
    }
    case 6:
    case 7: return is_control(word);
    case 8: return is_short_indirect(bits(word, 8, 8)) && is_short_indirect(bits(word, 0, 8));
    case 11: return bits(word, 23, 5) < 26 && is_source(word, Registers::any, all_modes);
    case 12:
    case 13:
    case 14:
    case 15: return is_pair(word);
    default: return false;
  }
}

}  // namespace reference
