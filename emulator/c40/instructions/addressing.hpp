#pragma once
/// Address generation and guarded accesses (c40-isa.md 3.2 to 3.10), as small objects from which handlers are composed.
#include <bit>

#include "c40/instructions/op.hpp"
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

/// The forms that are not a displacement without a buffer: an index register, circular, bit-reversed.
EffectiveAddress form_by_index(const Core& core, Word base, std::uint8_t modn, std::uint16_t displacement);

inline Word signed_displacement(const Op& op, std::size_t slot) {
  return static_cast<Word>(static_cast<std::int16_t>(op.displacement[slot]));
}

/// `updated` counts only if the form changes ARn (isa::modn::modifies).
inline EffectiveAddress form_indirect(const Core& core, const Op& op, std::size_t slot) {
  const Word base = core.r[op.ar[slot]];
  const std::uint8_t modn = op.modn[slot];
  if (modn >= movement::end) [[unlikely]]
    return form_by_index(core, base, modn, op.displacement[slot]);
  const Word moved = base + signed_displacement(op, slot);
  return {(modn & movement::before) != 0 ? moved : base, moved};
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
    if constexpr (kind == Kind::offset) formed.address = core.r[op.ar[s]] + signed_displacement(op, s);
    if constexpr (kind == Kind::indirect) {
      before = core.r[op.ar[s]];
      formed = form_indirect(core, op, s);
    }
    if constexpr (kind == Kind::post) {
      before = formed.address = core.r[op.ar[s]];
      formed.updated = before + signed_displacement(op, s);
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

/// The code comes by value: the compiler would read it again from the op after the first store.
inline void set_register(Core& core, std::uint8_t code, Float40 value) {
  core.e[code] = value.e;
  core.r[code] = value.m;
}

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
