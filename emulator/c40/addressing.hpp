#pragma once
/// Address generation and guarded accesses (c40-isa.md 3.2 to 3.10), as small objects from which handlers are composed.
#include <bit>

#include "c40/op.hpp"
#include "isa/decode.hpp"

namespace c40::execute {

struct EffectiveAddress {
  Address address;
  Word updated;  ///< ARn after the access
};

inline Word reverse_bits(Word x) {
  x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
  x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
  x = (x >> 4 & 0x0F0F0F0Fu) | (x & 0x0F0F0F0Fu) << 4;
  return __builtin_bswap32(x);
}

/// Only one correction, and the sum is not masked again (c40-isa.md 3.9).
inline Word circular(Word ar, Word bk, std::int64_t step) {
  const Word mask = bk == 0 ? 0u : ~Word{0} >> std::countl_zero(bk);
  const std::int64_t index = ar & mask;
  std::int64_t t = index + step;
  if (t >= bk)
    t -= bk;
  else if (t < 0)
    t += bk;
  return (ar & ~mask) + static_cast<Word>(t);
}

inline EffectiveAddress form_indirect(const Core& core, std::uint8_t ar, std::uint8_t modn,
                                      std::uint16_t displacement) {
  const Word base = core.r[ar];
  if (modn == 24) return {base, base};
  if (modn == 25) return {base, reverse_bits(reverse_bits(base) + reverse_bits(core.r[reg::IR0]))};
  const Word step = modn < 8 ? displacement : core.r[modn < 16 ? reg::IR0 : reg::IR1];
  switch (modn & 7) {
    case 0: return {base + step, base};
    case 1: return {base - step, base};
    case 2: return {base + step, base + step};
    case 3: return {base - step, base - step};
    case 4: return {base, base + step};
    case 5: return {base, base - step};
    case 6: return {base, circular(base, core.r[reg::BK], step)};
    default: return {base, circular(base, core.r[reg::BK], -std::int64_t{step})};
  }
}

/// A place in memory, accessed by access `slot` of the op. Usage: form all places of an instruction from the old
/// registers; then update all (the J byte's last); then check the guards, and undo the updates if one does not hold.
template <Kind kind, int slot>
struct Place {
  static constexpr auto s = static_cast<std::size_t>(slot);
  EffectiveAddress formed{};
  Word before = 0;

  void form(const Core& core, const Op& op) {
    if constexpr (kind == Kind::direct) formed.address = core.r[reg::DP] << 16 | op.displacement[s];
    if constexpr (kind == Kind::offset)
      formed.address = core.r[op.ar[s]] + static_cast<Word>(static_cast<std::int16_t>(op.displacement[s]));
    if constexpr (kind == Kind::indirect) {
      before = core.r[op.ar[s]];
      formed = form_indirect(core, op.ar[s], op.modn[s], op.displacement[s]);
    }
    if constexpr (kind == Kind::post) {
      before = formed.address = core.r[op.ar[s]];
      formed.updated = before + static_cast<Word>(static_cast<std::int16_t>(op.displacement[s]));
    }
    if constexpr (kind == Kind::circular) {
      before = formed.address = core.r[op.ar[s]];
      const Word bk = core.r[reg::BK], mask = (std::uint32_t{2} << (31 - std::countl_zero(bk | 1u))) - 1;
      const Word t = (before & mask) + op.displacement[s];
      formed.updated = (before & ~mask) + (t >= bk ? t - bk : t);
    }
  }
  void update(Core& core, const Op& op) const {
    // A second operand that uses the same ARn without changing it must not undo the first operand's update.
    if constexpr (kind == Kind::indirect) {
      if (!isa::modn::modifies(op.modn[s])) return;
    }
    if constexpr (updates_register(kind)) core.r[op.ar[s]] = formed.updated;
  }
  void undo(Core& core, const Op& op) const {
    if constexpr (updates_register(kind)) core.r[op.ar[s]] = before;
  }
  bool met(const Op& op) const {
    if constexpr (is_memory(kind)) return formed.address - op.access[s].base < op.access[s].words;
    return true;
  }
  Word read(const Op& op) const { return op.access[s].data[formed.address - op.access[s].base]; }
  /// True if the word belongs to predecoded code.
  bool write(const Op& op, Word value) const {
    const Window& window = op.access[s];
    const Word offset = formed.address - window.base;
    window.data[offset] = value;
    return (window.data[window.words + (offset >> 5)] >> (offset & 31) & 1u) != 0;
  }
  Word integer(const Core& core, const Op& op, std::uint8_t code) const {
    if constexpr (kind == Kind::reg) return core.r[code];
    if constexpr (kind == Kind::constant) return op.immediate;
    if constexpr (is_memory(kind)) return read(op);
    return 0;
  }
  Float40 floating(const Core& core, const Op& op, std::uint8_t code) const {
    if constexpr (kind == Kind::reg) return {core.e[code], core.r[code]};
    if constexpr (kind == Kind::constant) return float40::from_single(op.immediate);
    if constexpr (is_memory(kind)) return float40::from_single(read(op));
    return {};
  }
};

inline void set_logic(Core& core, Word value) {
  core.negative = core.zero = value;
  core.range = 0;
}

inline void latch(Core& core, Word range) {
  core.range = range;
  if (range != 0) [[unlikely]]
    core.sticky |= (range & st::V) << 4 | (range & st::UF) << 2;
}

inline void set_float(Core& core, Word flags) {
  core.negative = flags << 28;
  core.zero = ~flags & st::Z;
  latch(core, flags & (st::V | st::UF));
}

[[gnu::always_inline]] inline bool holds(const Core& core, isa::Condition condition) {
  using enum isa::Condition;
  const bool n = core.negative >> 31 != 0, z = core.zero == 0, c = (core.carry & 1) != 0;
  switch (condition) {
    case U: return true;
    case LO: return c;
    case LS: return c || z;
    case HI: return !c && !z;
    case HS: return !c;
    case EQ: return z;
    case NE: return !z;
    case LT: return n;
    case LE: return n || z;
    case GT: return !n && !z;
    case GE: return !n;
    case NV: return (core.range & st::V) == 0;
    case V: return (core.range & st::V) != 0;
    case NUF: return (core.range & st::UF) == 0;
    case UF: return (core.range & st::UF) != 0;
    case NLV: return (core.sticky & st::LV) == 0;
    case LV: return (core.sticky & st::LV) != 0;
    case NLUF: return (core.sticky & st::LUF) == 0;
    case LUF: return (core.sticky & st::LUF) != 0;
    case ZUF: return z || (core.range & st::UF) != 0;
  }
  return false;
}

}  // namespace c40::execute
