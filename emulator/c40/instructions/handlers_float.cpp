#include "c40/instructions/handler_tables.hpp"
#include "c40/instructions/handlers.hpp"

namespace c40::execute {
namespace {

using isa::Operation;

struct Body {
  static constexpr bool writes = true, sets_flags = true, keeps_zero = false;
};
struct Addf : Body {
  static FloatResult run(Float40 a, Float40 b) { return float40::add(a, b); }
};
struct Subf : Body {
  static FloatResult run(Float40 a, Float40 b) { return float40::sub(a, b); }
};
struct Cmpf : Subf {
  static constexpr bool writes = false;
};
struct Mpyf : Body {
  static FloatResult run(Float40 a, Float40 b) { return float40::mul(a, b); }
};
struct Absf : Body {
  static FloatResult run(Float40 a, Float40) { return float40::abs(a); }
};
struct Negf : Body {
  static FloatResult run(Float40 a, Float40) { return float40::neg(a); }
};
struct Rnd : Body {
  static constexpr bool keeps_zero = !choices::rnd_clears_zero;
  static FloatResult run(Float40 a, Float40) { return float40::rnd(a); }
};
struct Toieee : Body {
  static FloatResult run(Float40 a, Float40) { return float40::to_ieee(a); }
};
struct Rcpf : Body {
  static FloatResult run(Float40 a, Float40) { return float40::rcp(a); }
};
struct Rsqrf : Body {
  static FloatResult run(Float40 a, Float40) { return float40::rsqr(a); }
};
struct Ldf : Body {
  static FloatResult run(Float40 a, Float40) { return float40::load(a); }
};
struct SilentLdf : Ldf {
  static constexpr bool sets_flags = false;
};
/// The exponent of a, the old mantissa of dst.
struct Lde : SilentLdf {
  static FloatResult run(Float40 a, Float40 b) { return {float40::canonical({a.e, b.m}), 0}; }
};

/// Forms whose input is not two floats: `fetch` gives one input, `apply` does the rest.
template <class Derived>
struct UnaryForm {
  template <class A, class B>
  static void run(Core& core, const Op& op, const A& a, const B& b) {
    Derived::apply(core, op, Derived::fetch(core, op, a, b));
  }
  static void write(Core& core, const Op& op, const FloatResult& result) {
    set_float(core, result.flags);
    set_register(core, op.dst, result.value);
  }
};

/// The source word unchanged: the mantissa is kept even if the exponent is that of zero.
struct NormForm : UnaryForm<NormForm> {
  template <Kind kind, int slot, class B>
  static Float40 fetch(const Core& core, const Op& op, const Place<kind, slot>& a, const B&) {
    if constexpr (is_memory(kind)) return float40::from_single_raw(a.read(op));
    return a.floating(core, op, op.src1);
  }
  static void apply(Core& core, const Op& op, Float40 x) { write(core, op, float40::norm(x)); }
};

struct FrieeeForm : UnaryForm<FrieeeForm> {
  template <class A, class B>
  static Word fetch(const Core& core, const Op& op, const A& a, const B&) {
    return a.integer(core, op, op.src1);
  }
  static void apply(Core& core, const Op& op, Word word) { write(core, op, float40::from_ieee(word)); }
};

struct FloatFromInteger : UnaryForm<FloatFromInteger> {
  template <class A, class B>
  static Word fetch(const Core& core, const Op& op, const A& a, const B&) {
    return a.integer(core, op, op.src1);
  }
  static void apply(Core& core, const Op& op, Word word) { write(core, op, float40::from_integer(word)); }
};

/// Only bits 31..0 of the destination change.
template <bool flags>
struct FixForm : UnaryForm<FixForm<flags>> {
  template <class A, class B>
  static Float40 fetch(const Core& core, const Op& op, const A& a, const B&) {
    return a.floating(core, op, op.src1);
  }
  static void apply(Core& core, const Op& op, Float40 x) {
    const FixResult result = float40::fix(x);
    if constexpr (flags) set_float(core, result.flags);
    core.r[op.dst] = result.value;
  }
};

/// LDM: the whole source word becomes the mantissa.
using LdmForm = IntegerForm<integer::Lda, false>;

template <bool floating, Kind kind, class Test>
Outcome conditional_load(Core& core, const Op* op) {
  Place<kind, 0> a;
  a.form(core, *op);
  a.update(core, *op);
  if (!a.met(*op)) [[unlikely]] {
    a.undo(core, *op);
    return miss(core, op, 0, a.formed.address);
  }
  if constexpr (floating) {
    const Float40 value = float40::canonical(a.floating(core, *op, op->src1));
    if (Test::holds(core, *op)) {
      set_register(core, op->dst, value);
    }
  } else {
    const Word value = a.integer(core, *op, op->src1);
    if (Test::holds(core, *op)) core.r[op->dst] = value;
  }
  return next(core, op);
}

template <bool floating>
Word stored(const Core& core, std::uint8_t code) {
  return floating ? float40::to_single({core.e[code], core.r[code]}) : core.r[code];
}

template <bool floating, Kind from, Kind to>
Outcome store(Core& core, const Op* op) {
  Place<to, 0> place;
  place.form(core, *op);
  place.update(core, *op);
  const Word value = from == Kind::constant ? op->immediate : stored<floating>(core, op->src1);
  if (!place.met(*op)) [[unlikely]] {
    place.undo(core, *op);
    return miss_write(core, op, 0, place.formed.address, value);
  }
  const bool code = place.write(*op, value);
  return finish_store(core, op, code, place.formed.address);
}

/// The two accesses of a parallel instruction: access 0 is the J byte, access 1 the I byte.
template <Kind kind>
struct Pair {
  Place<kind, 0> j;
  Place<kind, 1> i;

  /// Neither address sees the other's update; of two updates of one register J's stays. If this is false, the registers
  /// are as before.
  [[gnu::always_inline]] bool meet(Core& core, const Op& op) {
    j.form(core, op);
    i.form(core, op);
    i.update(core, op);
    j.update(core, op);
    if (j.met(op) && i.met(op)) [[likely]]
      return true;
    i.undo(core, op);
    j.undo(core, op);
    return false;
  }
  [[gnu::always_inline]] Outcome missed(Core& core, const Op* op) const {
    return j.met(*op) ? miss(core, op, 1, i.formed.address) : miss(core, op, 0, j.formed.address);
  }
  /// The values that J and I store.
  [[gnu::always_inline]] Outcome missed(Core& core, const Op* op, Word first, Word second) const {
    return j.met(*op) ? miss_write(core, op, 1, i.formed.address, second)
                      : miss_write(core, op, 0, j.formed.address, first);
  }
};

/// J loads src3 -> dst2, I src1 -> dst; if both have one destination, dst stays.
template <bool floating>
Outcome load_load(Core& core, const Op* op) {
  Pair<Kind::indirect> pair;
  if (!pair.meet(core, *op)) [[unlikely]]
    return pair.missed(core, op);
  const auto& [j, i] = pair;
  if constexpr (floating) {
    const Float40 x = i.floating(core, *op, 0);
    const Float40 y = choices::j_load_keeps_mantissa ? float40::from_single_raw(j.read(*op)) : j.floating(core, *op, 0);
    set_register(core, op->dst2, y);
    set_register(core, op->dst, x);
  } else {
    const Word x = i.read(*op), y = j.read(*op);
    core.r[op->dst2] = y;
    core.r[op->dst] = x;
  }
  return next(core, op);
}

/// J is written first; I's value stays if both have one address.
template <bool floating>
Outcome store_store(Core& core, const Op* op) {
  const Word first = stored<floating>(core, op->src3), second = stored<floating>(core, op->src1);
  Pair<Kind::indirect> pair;
  if (!pair.meet(core, *op)) [[unlikely]]
    return pair.missed(core, op, first, second);
  const auto& [j, i] = pair;
  const bool j_code = j.write(*op, first), i_code = i.write(*op, second);
  if (j_code || i_code) [[unlikely]] {
    if (j_code) code_written(core, j.formed.address);
    if (i_code) code_written(core, i.formed.address);
    return {op, Exit::left_after};
  }
  return next(core, op);
}

/// MPY3 || ADD3/SUB3: P assigns J and I to the sources (c40-isa.md 3.6).
template <bool floating, bool subtract, int p, Kind kind = Kind::indirect>
Outcome multiply_add(Core& core, const Op* op) {
  Pair<kind> pair;
  if (!pair.meet(core, *op)) [[unlikely]]
    return pair.missed(core, op);
  const auto& [j, i] = pair;
  if constexpr (floating) {
    const Float40 vj = j.floating(core, *op, 0), vi = i.floating(core, *op, 0);
    const auto reg = [&](std::uint8_t code) { return Float40{core.e[code], core.r[code]}; };
    const Float40 x = p == 0 ? vj : reg(op->src1), y = p == 0 ? vi : p == 2 ? reg(op->src2) : vj;
    const Float40 u = p == 1 ? vi : p == 2 ? vj : reg(op->src3), v = p == 0 || p == 1 ? reg(op->src4) : vi;
    const FloatResult product = p == 0 ? float40::mul_singles(j.read(*op), i.read(*op)) : float40::mul(x, y);
    const FloatResult sum = subtract ? float40::sub(u, v) : float40::add(u, v);
    set_register(core, op->dst, product.value);
    set_register(core, op->dst2, sum.value);
    latch(core, (product.flags | sum.flags) & (st::V | st::UF));
  } else {
    const Word vj = j.read(*op), vi = i.read(*op);
    const auto reg = [&](std::uint8_t code) { return core.r[code]; };
    const Word x = p == 0 ? vj : reg(op->src1), y = p == 0 ? vi : p == 2 ? reg(op->src2) : vj;
    const Word u = p == 1 ? vi : p == 2 ? vj : reg(op->src3), v = p == 0 || p == 1 ? reg(op->src4) : vi;
    const Word carry = core.carry;
    const Word product = integer::Mpyi::run<true>(core, *op, x, y);
    const Word range = core.range;
    const Word sum = subtract ? integer::Subi::run<true>(core, *op, u, v) : integer::Addi::run<true>(core, *op, u, v);
    core.range |= range;
    core.carry = carry;
    core.r[op->dst] = product;
    core.r[op->dst2] = sum;
  }
  core.negative = 0;
  core.zero = 1;
  return next(core, op);
}

template <bool floating, bool subtract>
Handler multiply_add_by_product(int p) {
  switch (p) {
    case 0: return &multiply_add<floating, subtract, 0>;
    case 1: return &multiply_add<floating, subtract, 1>;
    case 2: return &multiply_add<floating, subtract, 2>;
    default: return &multiply_add<floating, subtract, 3>;
  }
}

/// The inner loops of filters: both operands have the same addressing.
template <bool subtract>
Handler float_multiply_add(int p, Kind kind) {
  if (p == 0 && kind == Kind::post) return &multiply_add<true, subtract, 0, Kind::post>;
  if (p == 0 && kind == Kind::circular) return &multiply_add<true, subtract, 0, Kind::circular>;
  return multiply_add_by_product<true, subtract>(p);
}

template <bool floating, Kind from>
Handler store_to(Kind to) {
  switch (to) {
    case Kind::direct: return &store<floating, from, Kind::direct>;
    case Kind::offset: return &store<floating, from, Kind::offset>;
    case Kind::indirect: return &store<floating, from, Kind::indirect>;
    default: return nullptr;
  }
}

template <bool floating, class Test>
Handler conditional_load_from(Kind a) {
  switch (a) {
    case Kind::reg: return &conditional_load<floating, Kind::reg, Test>;
    case Kind::constant: return &conditional_load<floating, Kind::constant, Test>;
    case Kind::direct: return &conditional_load<floating, Kind::direct, Test>;
    case Kind::offset: return &conditional_load<floating, Kind::offset, Test>;
    case Kind::indirect: return &conditional_load<floating, Kind::indirect, Test>;
    default: return nullptr;
  }
}

}  // namespace

Handler float_handler(Operation operation, Kind a, Kind b, bool flags) {
  switch (operation) {
    case Operation::addf: return two_sources<FloatForm<Addf>>(a, b);
    case Operation::subf: return two_sources<FloatForm<Subf>>(a, b);
    case Operation::mpyf: return two_sources<FloatForm<Mpyf>>(a, b);
    case Operation::cmpf: return two_sources<FloatForm<Cmpf>>(a, b);
    case Operation::lde: return two_sources<FloatForm<Lde>>(a, b);
    case Operation::absf: return one_source<FloatForm<Absf>>(a);
    case Operation::negf: return one_source<FloatForm<Negf>>(a);
    case Operation::rnd: return one_source<FloatForm<Rnd>>(a);
    case Operation::toieee: return one_source<FloatForm<Toieee>>(a);
    case Operation::rcpf: return one_source<FloatForm<Rcpf>>(a);
    case Operation::rsqrf: return one_source<FloatForm<Rsqrf>>(a);
    case Operation::ldf:
    case Operation::ldfi: return one_source<FloatForm<Ldf>>(a);
    case Operation::ldm: return one_source<LdmForm>(a);
    case Operation::norm: return one_source<NormForm>(a);
    case Operation::frieee: return one_source<FrieeeForm>(a);
    case Operation::float_: return one_source<FloatFromInteger>(a);
    case Operation::fix: return flags ? one_source<FixForm<true>>(a) : one_source<FixForm<false>>(a);
    default: return nullptr;
  }
}

Handler float_store_handler(Operation operation, Kind a, Kind b) {
  switch (operation) {
    case Operation::absf: return with_store<FloatForm<Absf>, true>(a, b);
    case Operation::addf: return with_store<FloatForm<Addf>, true>(a, b);
    case Operation::fix: return with_store<FixForm<true>, false>(a, b);
    case Operation::float_: return with_store<FloatFromInteger, true>(a, b);
    case Operation::ldf: return with_store<FloatForm<SilentLdf>, true>(a, b);
    case Operation::mpyf: return with_store<FloatForm<Mpyf>, true>(a, b);
    case Operation::negf: return with_store<FloatForm<Negf>, true>(a, b);
    case Operation::subf: return with_store<FloatForm<Subf>, true>(a, b);
    case Operation::toieee: return with_store<FloatForm<Toieee>, true>(a, b);
    case Operation::frieee: return with_store<FrieeeForm, true>(a, b);
    default: return nullptr;
  }
}

Handler conditional_load_handler(bool floating, isa::Condition condition, Kind a) {
  return with_test(condition, [&]<class Test>(Test) {
    return floating ? conditional_load_from<true, Test>(a) : conditional_load_from<false, Test>(a);
  });
}

Handler store_handler(bool floating, Kind from, Kind to) {
  if (from == Kind::constant) return store_to<false, Kind::constant>(to);
  return floating ? store_to<true, Kind::reg>(to) : store_to<false, Kind::reg>(to);
}

Handler load_load_handler(bool floating) { return floating ? &load_load<true> : &load_load<false>; }
Handler store_store_handler(bool floating) { return floating ? &store_store<true> : &store_store<false>; }

Handler multiply_add_handler(bool floating, bool subtract, int product, Kind kind) {
  if (floating) return subtract ? float_multiply_add<true>(product, kind) : float_multiply_add<false>(product, kind);
  return subtract ? multiply_add_by_product<false, true>(product) : multiply_add_by_product<false, false>(product);
}

}  // namespace c40::execute
