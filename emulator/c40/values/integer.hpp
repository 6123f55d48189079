#pragma once
/// Integer semantics (c40-isa.md 5, 6.1 to 6.3, 7.8, 7.9, 7.11). Each body computes `dst <- op(src1, src2)` and, if
/// `flags`, the condition flags. Saturation happens with or without flags.
#include "c40/instructions/addressing.hpp"

namespace c40::execute::integer {

struct Shifted {
  Word value;
  Word carry;
};

/// Classes A and B: makes the written value from the wrapped result with its carry and overflow.
template <bool flags, bool set_carry, bool saturates = true>
[[gnu::always_inline]] inline Word arithmetic(Core& core, Word wrapped, Word carry, bool overflow) {
  const Word true_sign = overflow ? ~wrapped : wrapped;
  Word out = wrapped;
  if (overflow) [[unlikely]] {
    if (saturates && (core.modes & st::OVM) != 0) out = true_sign >> 31 ? 0x80000000u : 0x7FFFFFFFu;
    if (flags) core.sticky |= st::LV;
  }
  if constexpr (flags) {
    core.negative = true_sign;
    core.zero = choices::zero_follows_output || !overflow ? out : 1u;
    core.range = overflow ? st::V : 0u;
    if constexpr (set_carry) core.carry = carry;
  }
  return out;
}

template <bool flags, bool saturates = true>
[[gnu::always_inline]] inline Word add(Core& core, Word a, Word b, Word carry_in) {
  const std::uint64_t sum = std::uint64_t{a} + b + carry_in;
  const auto wrapped = static_cast<Word>(sum);
  const bool overflow = ((a ^ wrapped) & (b ^ wrapped)) >> 31 != 0;
  return arithmetic<flags, true, saturates>(core, wrapped, static_cast<Word>(sum >> 32), overflow);
}

template <bool flags, bool saturates = true>
[[gnu::always_inline]] inline Word subtract(Core& core, Word a, Word b, Word borrow_in) {
  const std::uint64_t difference = std::uint64_t{a} - b - borrow_in;
  const auto wrapped = static_cast<Word>(difference);
  const bool overflow = ((a ^ b) & (a ^ wrapped)) >> 31 != 0;
  return arithmetic<flags, true, saturates>(core, wrapped, static_cast<Word>(difference >> 32) & 1u, overflow);
}

template <bool flags>
Word logic(Core& core, Word value) {
  if constexpr (flags) set_logic(core, value);
  return value;
}

/// Count: the sign-extended 7 low bits (c40-isa.md 7.8).
inline std::int32_t shift_count(Word word) { return static_cast<std::int32_t>(word << 25) >> 25; }

inline Shifted shift_logical(Word x, std::int32_t n) {
  if (n == 0) return {x, 0};
  if (n > 0) return {n < 32 ? x << n : 0u, n < 32 ? x >> (32 - n) & 1u : x & 1u};
  n = -n;
  return {n < 32 ? x >> n : 0u, n <= 32 ? x >> (n - 1) & 1u : 0u};
}

inline Shifted shift_arithmetic(Word x, std::int32_t n) {
  if (n >= 0) return shift_logical(x, n);
  n = -n;
  const auto s = static_cast<std::int32_t>(x);
  return {static_cast<Word>(s >> (n < 32 ? n : 31)), static_cast<Word>(s >> (n <= 32 ? n - 1 : 31)) & 1u};
}

inline bool left_shift_overflows(Word x, std::int32_t n) {
  if (n <= 0) return false;
  if (n >= 32) return x != 0;
  const std::int64_t wide = static_cast<std::int64_t>(static_cast<std::int32_t>(x)) * (std::int64_t{1} << n);
  return wide != static_cast<std::int32_t>(wide);
}

template <bool flags>
Word rotate(Core& core, Word value, Word carry) {
  if constexpr (flags) {
    set_logic(core, value);
    core.carry = carry;
  }
  return value;
}

struct Writes {
  static constexpr bool writes = true;
};
struct Compares {
  static constexpr bool writes = false;
};

#define C40_BODY(Name, Base, ...)                                                                        \
  struct Name : Base {                                                                                   \
    template <bool flags>                                                                                \
    static Word run([[maybe_unused]] Core& core, [[maybe_unused]] const Op& op, [[maybe_unused]] Word a, \
                    [[maybe_unused]] Word b) {                                                           \
      __VA_ARGS__                                                                                        \
    }                                                                                                    \
  };

C40_BODY(Addi, Writes, return add<flags>(core, a, b, 0);)
C40_BODY(Addc, Writes, return add<flags>(core, a, b, core.carry & 1);)
C40_BODY(Subi, Writes, return subtract<flags>(core, a, b, 0);)
C40_BODY(Subb, Writes, return subtract<flags>(core, a, b, core.carry & 1);)
C40_BODY(Cmpi, Compares, return (subtract<flags, false>)(core, a, b, 0);)
C40_BODY(Negi, Writes, return subtract<flags>(core, 0, a, 0);)
C40_BODY(Negb, Writes, return subtract<flags>(core, 0, a, core.carry & 1);)
C40_BODY(And, Writes, return logic<flags>(core, a& b);)
C40_BODY(Andn, Writes, return logic<flags>(core, a & ~b);)
C40_BODY(Or, Writes, return logic<flags>(core, a | b);)
C40_BODY(Xor, Writes, return logic<flags>(core, a ^ b);)
C40_BODY(Tstb, Compares, return logic<flags>(core, a& b);)
C40_BODY(Not, Writes, return logic<flags>(core, ~a);)
C40_BODY(Ldi, Writes, return logic<flags>(core, a);)
C40_BODY(Ldhi, Writes, return a << 16;)
C40_BODY(Lda, Writes, return a;)

C40_BODY(
    Absi, Writes, const bool overflow = a == 0x80000000u; Word out = a >> 31 ? 0u - a : a; if (overflow) {
      if ((core.modes & st::OVM) != 0) out = 0x7FFFFFFFu;
      if (flags) core.sticky |= st::LV;
    } if (flags) {
      core.negative = 0;
      core.zero = out;
      core.range = overflow ? st::V : 0u;
    } return out;)

C40_BODY(
    Mpyi, Writes,
    const std::int64_t product = std::int64_t{static_cast<std::int32_t>(a)} * static_cast<std::int32_t>(b);
    const bool overflow = product != static_cast<std::int32_t>(product);
    // A wrapped product may have either sign, so the true sign is passed instead of derived.
    Word out = static_cast<Word>(product);
    if (overflow) [[unlikely]] {
      if ((core.modes & st::OVM) != 0) out = product < 0 ? 0x80000000u : 0x7FFFFFFFu;
      if (flags) core.sticky |= st::LV;
    } if (flags) {
      core.negative = static_cast<Word>(static_cast<std::uint64_t>(product) >> 32);
      core.zero = choices::zero_follows_output || !overflow ? out : 1u;
      core.range = overflow ? st::V : 0u;
    } return out;)
C40_BODY(Mpyshi, Writes,
         const std::int64_t product = std::int64_t{static_cast<std::int32_t>(a)} * static_cast<std::int32_t>(b);
         return logic<flags>(core, static_cast<Word>(static_cast<std::uint64_t>(product) >> 32));)
C40_BODY(Mpyuhi, Writes, return logic<flags>(core, static_cast<Word>(std::uint64_t{a} * b >> 32));)

C40_BODY(Lsh, Writes, const Shifted s = shift_logical(a, shift_count(b)); return rotate<flags>(core, s.value, s.carry);)
C40_BODY(
    Ash, Writes, const std::int32_t n = shift_count(b); const Shifted s = shift_arithmetic(a, n); if (flags) {
      set_logic(core, s.value);
      core.carry = s.carry;
      if (choices::ash_reports_overflow && left_shift_overflows(a, n)) latch(core, st::V);
    } return s.value;)
C40_BODY(Rol, Writes, return rotate<flags>(core, a << 1 | a >> 31, a >> 31);)
C40_BODY(Rolc, Writes, return rotate<flags>(core, a << 1 | (core.carry & 1), a >> 31);)
C40_BODY(Ror, Writes, return rotate<flags>(core, a >> 1 | a << 31, a & 1);)
C40_BODY(Rorc, Writes, return rotate<flags>(core, a >> 1 | core.carry << 31, a & 1);)

/// One step of restoring division: a is dst, b the divisor; unsigned.
C40_BODY(Subc, Writes, return a >= b ? (a - b) << 1 | 1u : a << 1;)

C40_BODY(Lb, Writes, return logic<flags>(core, static_cast<Word>(static_cast<std::int8_t>(a >> 8 * op.selector)));)
C40_BODY(Lbu, Writes, return logic<flags>(core, a >> 8 * op.selector & 0xFFu);)
C40_BODY(Lh, Writes, return logic<flags>(core, static_cast<Word>(static_cast<std::int16_t>(a >> 16 * op.selector)));)
C40_BODY(Lhu, Writes, return logic<flags>(core, a >> 16 * op.selector & 0xFFFFu);)
/// Merges of a (memory) into b (the old dst).
C40_BODY(Lwl, Writes, const Word keep = (1u << 8 * op.selector) - 1;
         return logic<flags>(core, a << 8 * op.selector | (b & keep));)
C40_BODY(Lwr, Writes, const Word moved = ~Word{0} >> 8 * op.selector;
         return logic<flags>(core, a >> 8 * op.selector | (choices::lwr_keeps_high_bytes ? b & ~moved : 0u));)
C40_BODY(Mb, Writes, const Word field = 0xFFu << 8 * op.selector;
         return logic<flags>(core, (a << 8 * op.selector & field) | (b & ~field));)
C40_BODY(Mh, Writes, const Word field = 0xFFFFu << 16 * op.selector;
         return logic<flags>(core, (a << 16 * op.selector & field) | (b & ~field));)

#undef C40_BODY

}  // namespace c40::execute::integer
