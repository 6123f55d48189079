#pragma once
/// Handlers, composed of a body, the places of its operands and, for parallel instructions, a store.
#include "c40/instructions/addressing.hpp"
#include "c40/values/integer.hpp"

namespace c40::execute {

/// The store half of a parallel instruction, through access `slot` and the J byte.
template <int slot, bool floating>
struct ParallelStore {
  Place<Kind::indirect, slot> place;
  Word value = 0;
  void form(const Core& core, const Op& op) { place.form(core, op); }
  void update(Core& core, const Op& op) const { place.update(core, op); }
  void undo(Core& core, const Op& op) const { place.undo(core, op); }
  /// The stored register's value after the address updates and before any result.
  void fetch(const Core& core, const Op& op) {
    value = floating ? float40::to_single({core.e[op.src3], core.r[op.src3]}) : core.r[op.src3];
  }
  bool met(const Op& op) const { return place.met(op); }
  Outcome missed(Core& core, const Op* op) const { return miss_write(core, op, slot, place.formed.address, value); }
  bool perform(const Op& op) const { return place.write(op, value); }
};

struct NoStore {
  void form(const Core&, const Op&) {}
  void update(Core&, const Op&) const {}
  void undo(Core&, const Op&) const {}
  void fetch(const Core&, const Op&) {}
  bool met(const Op&) const { return true; }
  Outcome missed(Core&, const Op* op) const { return {op, Exit::miss}; }
  bool perform(const Op&) const { return false; }
};

inline Outcome finish_store(Core& core, const Op* op, bool code, Address address) {
  if (code) [[unlikely]] {
    code_written(core, address);
    return {op, Exit::left_after};
  }
  return next(core, op);
}

/// dst <- body(src1, src2) [|| store]. `Form`: the operands' type.
template <class Form, Kind ka, Kind kb, class Store>
Outcome compute(Core& core, const Op* op) {
  Place<ka, 0> a;
  Place<kb, is_memory(ka) ? 1 : 0> b;
  Store store;
  a.form(core, *op);
  b.form(core, *op);
  store.form(core, *op);
  b.update(core, *op);
  a.update(core, *op);
  store.update(core, *op);
  const auto undo = [&] {
    a.undo(core, *op);
    b.undo(core, *op);
    store.undo(core, *op);
  };
  if (!a.met(*op)) [[unlikely]] {
    undo();
    return miss(core, op, 0, a.formed.address);
  }
  if (!b.met(*op)) [[unlikely]] {
    undo();
    return miss(core, op, is_memory(ka) ? 1 : 0, b.formed.address);
  }
  store.fetch(core, *op);
  if (!store.met(*op)) [[unlikely]] {
    undo();
    return store.missed(core, op);
  }
  if constexpr (std::is_same_v<Store, NoStore>) {
    Form::run(core, *op, a, b);
    return next(core, op);
  } else {
    const auto inputs = Form::fetch(core, *op, a, b);
    const bool code = store.perform(*op);
    Form::apply(core, *op, inputs);
    return finish_store(core, op, code, store.place.formed.address);
  }
}

template <class Body, bool flags>
struct IntegerForm {
  struct Inputs {
    Word a, b;
  };
  template <class A, class B>
  static Inputs fetch(const Core& core, const Op& op, const A& a, const B& b) {
    return {a.integer(core, op, op.src1), b.integer(core, op, op.src2)};
  }
  static void apply(Core& core, const Op& op, Inputs in) {
    const Word value = Body::template run<flags>(core, op, in.a, in.b);
    if constexpr (Body::writes) core.r[op.dst] = value;
  }
  template <class A, class B>
  static void run(Core& core, const Op& op, const A& a, const B& b) {
    apply(core, op, fetch(core, op, a, b));
  }
};

/// Body: FloatResult run(Float40 a, Float40 b).
template <class Body>
struct FloatForm {
  struct Inputs {
    Float40 a, b;
  };
  template <class A, class B>
  static Inputs fetch(const Core& core, const Op& op, const A& a, const B& b) {
    return {a.floating(core, op, op.src1), b.floating(core, op, op.src2)};
  }
  static void apply(Core& core, const Op& op, Inputs in) {
    const FloatResult result = Body::run(in.a, in.b);
    if constexpr (Body::sets_flags) {
      const Word zero = core.zero;
      set_float(core, result.flags);
      if constexpr (Body::keeps_zero) core.zero = zero;
    }
    if constexpr (Body::writes) set_register(core, op.dst, result.value);
  }
  template <class A, class B>
  static void run(Core& core, const Op& op, const A& a, const B& b) {
    apply(core, op, fetch(core, op, a, b));
  }
};

/// A unary form whose input is not simply an integer or a float. Body: Input fetch<kind>(...); void apply(Core&, Op&,
/// Input).
constexpr int combination(Kind a, Kind b) { return static_cast<int>(a) * 8 + static_cast<int>(b); }

/// The combinations of operands of two-source instructions (c40-isa.md 3.2 and 3.4); null for others.
template <class Form>
Handler two_sources(Kind a, Kind b) {
  using enum Kind;
  switch (combination(a, b)) {
    case combination(reg, reg): return &compute<Form, reg, reg, NoStore>;
    case combination(reg, constant): return &compute<Form, reg, constant, NoStore>;
    case combination(reg, direct): return &compute<Form, reg, direct, NoStore>;
    case combination(reg, offset): return &compute<Form, reg, offset, NoStore>;
    case combination(reg, indirect): return &compute<Form, reg, indirect, NoStore>;
    case combination(constant, reg): return &compute<Form, constant, reg, NoStore>;
    case combination(direct, reg): return &compute<Form, direct, reg, NoStore>;
    case combination(offset, reg): return &compute<Form, offset, reg, NoStore>;
    case combination(indirect, reg): return &compute<Form, indirect, reg, NoStore>;
    case combination(offset, constant): return &compute<Form, offset, constant, NoStore>;
    case combination(offset, offset): return &compute<Form, offset, offset, NoStore>;
    case combination(offset, indirect): return &compute<Form, offset, indirect, NoStore>;
    case combination(indirect, offset): return &compute<Form, indirect, offset, NoStore>;
    case combination(indirect, indirect): return &compute<Form, indirect, indirect, NoStore>;
    default: return nullptr;
  }
}

template <class Form>
Handler one_source(Kind a) {
  using enum Kind;
  switch (a) {
    case reg: return &compute<Form, reg, none, NoStore>;
    case constant: return &compute<Form, constant, none, NoStore>;
    case direct: return &compute<Form, direct, none, NoStore>;
    case offset: return &compute<Form, offset, none, NoStore>;
    case indirect: return &compute<Form, indirect, none, NoStore>;
    case circular: return &compute<Form, circular, none, NoStore>;
    default: return nullptr;
  }
}

/// Operation || store: one source is the I byte.
template <class Form, bool floating>
Handler with_store(Kind a, Kind b) {
  using enum Kind;
  using Store = ParallelStore<1, floating>;
  if (b == none) return &compute<Form, indirect, none, Store>;
  return a == reg ? &compute<Form, reg, indirect, Store> : &compute<Form, indirect, reg, Store>;
}

/// How a handler tests its condition: a common condition is fixed when the instruction is bound, any other is looked up
/// in the op at each execution.
template <isa::Condition condition>
struct FixedTest {
  static bool holds(const Core& core, const Op&) { return execute::holds(core, condition); }
};
struct OpTest {
  static bool holds(const Core& core, const Op& op) {
    return execute::holds(core, static_cast<isa::Condition>(op.selector));
  }
};

/// handler_of(Test{}) with the condition's test.
template <class HandlerOf>
Handler with_test(isa::Condition condition, HandlerOf&& handler_of) {
  using enum isa::Condition;
  switch (condition) {
    case U: return handler_of(FixedTest<U>{});
    case LO: return handler_of(FixedTest<LO>{});
    case LS: return handler_of(FixedTest<LS>{});
    case HI: return handler_of(FixedTest<HI>{});
    case HS: return handler_of(FixedTest<HS>{});
    case EQ: return handler_of(FixedTest<EQ>{});
    case NE: return handler_of(FixedTest<NE>{});
    case LT: return handler_of(FixedTest<LT>{});
    case LE: return handler_of(FixedTest<LE>{});
    case GT: return handler_of(FixedTest<GT>{});
    case GE: return handler_of(FixedTest<GE>{});
    default: return handler_of(OpTest{});
  }
}

}  // namespace c40::execute
