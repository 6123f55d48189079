// RPTS of MPYF3 *ARj++,*ARi++,Rp || ADDF3 Rp,Rs,Rs: the inner loop of filters and matrices, all its passes in one call.
// The arithmetic is that of float40, on mantissas that stay unpacked between passes.
#include <algorithm>

#include "c40/instructions/addressing.hpp"
#include "c40/instructions/handler_tables.hpp"

namespace c40::execute {
namespace {

/// A float with its mantissa in the form of float40::mantissa: 33 bits, 0 for zero.
struct Wide {
  std::int32_t e;
  std::int64_t m;
};

Wide unpacked(Float40 x) { return {x.e, float40::mantissa(x)}; }
Float40 packed(Wide x) { return x.m == 0 ? float40::zero() : float40::pack(x.e, x.m); }

/// The flags V and UF of the passes so far.
struct Flags {
  Word ever = 0;
  Word last = 0;       ///< of the last pass that set any
  Word last_pass = 0;  ///< this pass, counted down
  Word of(Word pass) const { return last_pass == pass ? last : 0; }
};

/// Handles exponents outside the range, as float40::finish does. By value, so that the flags stay in registers.
struct Saturated {
  Wide value;
  Flags flags;
};
[[gnu::cold, gnu::noinline]] Saturated saturated(Wide x, Flags flags, Word pass) {
  const FloatResult result = float40::finish(x.e, x.m);
  const Word set = result.flags & (st::V | st::UF);
  return {unpacked(result.value), {flags.ever | set, flags.of(pass) | set, pass}};
}

[[gnu::always_inline]] inline Wide normalised(std::int32_t e, std::int64_t s, Flags& flags, Word pass) {
  const int bits = float40::significant_bits(s);
  const Wide result{e + bits - 32, float40::with_32_bits(s, bits)};
  if (static_cast<std::uint32_t>(result.e + 127) <= 254u) [[likely]]
    return result;
  const Saturated handled = saturated(result, flags, pass);
  flags = handled.flags;
  return handled.value;
}

[[gnu::always_inline]] inline Wide product_of(Word a, Word b, Flags& flags, Word pass) {
  const float40::SingleProduct p = float40::product_of_singles(a, b);
  if (p.s == 0) [[unlikely]]
    return {float40::zero_exponent, 0};
  return normalised(p.e, p.s, flags, pass);
}

[[gnu::always_inline]] inline Wide sum_of(Wide a, Wide b, Flags& flags, Word pass) {
  const std::int32_t e = std::max(a.e, b.e);
  const std::int64_t s = (a.m >> std::min(e - a.e, 63)) + (b.m >> std::min(e - b.e, 63));
  if (s == 0) [[unlikely]]
    return {float40::zero_exponent, 0};
  return normalised(e, s, flags, pass);
}

/// The memory that all passes of one operand read: a window that contains it, or null.
template <Kind kind>
struct Walk {
  const Word* data = nullptr;
  Word at = 0, step = 0, length = 0;

  Walk(const Core& core, const Op& op, std::size_t slot, Word passes) {
    const Window& window = op.access[slot];
    const Word ar = core.r[op.ar[slot]];
    step = op.displacement[slot];
    if constexpr (kind == Kind::circular) {
      length = core.r[reg::BK];
      const Word mask = length == 0 ? 0u : ~Word{0} >> std::countl_zero(length);
      const Word first = (ar & ~mask) - window.base;
      at = ar & mask;
      if (at < length && step <= length && first < window.words && length <= window.words - first)
        data = window.data + first;
    } else {
      const Word first = ar - window.base;
      const std::uint64_t last = first + std::uint64_t{passes - 1} * step;
      if (first < window.words && last < window.words) data = window.data + first;
    }
  }
  [[gnu::always_inline]] Word next() {
    const Word word = data[at];
    at += step;
    if constexpr (kind == Kind::circular) at = at >= length ? at - length : at;
    return word;
  }
  void leave(Core& core, const Op& op, std::size_t slot) const {
    Word& ar = core.r[op.ar[slot]];
    if constexpr (kind == Kind::circular) {
      ar = (ar & ~(~Word{0} >> std::countl_zero(length))) + at;
    } else {
      ar += at;
    }
  }
};

template <Kind kind>
Outcome multiply_accumulate(Core& core, const Op* op) {
  const Word passes = core.loop_left + 1;
  Walk<kind> j(core, *op, 0, passes), i(core, *op, 1, passes);
  if (j.data == nullptr || i.data == nullptr) [[unlikely]]
    return multiply_add_handler(true, false, 0, kind)(core, op);
  Wide product = unpacked({core.e[op->dst], core.r[op->dst]});
  Wide sum = unpacked({core.e[op->dst2], core.r[op->dst2]});
  Flags flags;
  for (Word left = passes; left != 0; --left) {
    sum = sum_of(product, sum, flags, left);
    product = product_of(j.next(), i.next(), flags, left);
  }
  j.leave(core, *op, 0);
  i.leave(core, *op, 1);
  set_register(core, op->dst, packed(product));
  set_register(core, op->dst2, packed(sum));
  latch(core, flags.ever);
  core.range = flags.of(1);
  core.negative = 0;
  core.zero = 1;
  core.loop_left = 0;
  return next(core, op);
}

}  // namespace

Handler repeated_multiply_add_handler(const Op& op, Kind kind) {
  const bool accumulates = (op.src3 == op.dst && op.src4 == op.dst2) || (op.src3 == op.dst2 && op.src4 == op.dst);
  if (!accumulates) return nullptr;
  switch (kind) {
    case Kind::post: return &multiply_accumulate<Kind::post>;
    case Kind::circular: return &multiply_accumulate<Kind::circular>;
    default: return nullptr;
  }
}

}  // namespace c40::execute
