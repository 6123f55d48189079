// Stack, program control and traps (c40-isa.md 6.6 and 8). Handlers that change the PC return; after a delayed branch
// the three slots follow, and the end of the block takes the branch.
#include "c40/instructions/handler_tables.hpp"
#include "c40/instructions/handlers.hpp"

namespace c40::execute {
namespace {

using isa::Condition;
using isa::Operation;

Outcome leave(const Op* op, bool taken) { return {op, taken ? Exit::taken : Exit::not_taken}; }

Address target_of(const Core& core, const Op& op, bool relative) {
  return relative ? op.pc + op.immediate : core.r[op.src1];
}

/// Saves GIE and CF, and stops interrupts and updates of the cache (c40-isa.md 8.6).
void enter_handler(Core& core) {
  const Word modes = core.modes & ~(st::PGIE | st::PCF | st::GIE);
  core.modes = modes | (core.modes & st::GIE ? st::PGIE : 0u) | (core.modes & st::CF ? st::PCF : 0u) |
               (choices::entry_sets_cache_freeze ? st::CF : 0u);
}

void delay(Core& core, bool taken, Address target, Address straight_on) {
  core.delay_slots = 4;  // this instruction is counted too
  core.delay_taken = taken;
  core.delay_target = taken ? target : straight_on;
  core.delay_repeat = false;
  core.annul = false;
}

template <bool relative, class Test>
Outcome branch(Core& core, const Op* op) {
  const bool taken = Test::holds(core, *op);
  core.pc = taken ? target_of(core, *op, relative) : op->pc + 1;
  return leave(op, taken);
}

enum class Annul { never, if_true, if_false };

template <bool relative, Annul annul, class Test = OpTest>
Outcome branch_delayed(Core& core, const Op* op) {
  const bool taken = Test::holds(core, *op);
  delay(core, taken, target_of(core, *op, relative), op->pc + 4);
  if constexpr (annul != Annul::never) {
    core.annul = taken == (annul == Annul::if_true);
    core.pc = op->pc + 1;
    return leave(op, taken);
  }
  return next(core, op);
}

/// The condition uses the flags before the instruction; the target is read before the counter is decremented.
template <bool relative, bool delayed, class Test>
Outcome decrement_and_branch(Core& core, const Op* op) {
  const Address target = target_of(core, *op, relative);
  const bool met = Test::holds(core, *op);
  if (choices::db_counts_on_false || met) --core.r[op->dst];
  const bool taken = met && static_cast<std::int32_t>(core.r[op->dst]) >= 0;
  if constexpr (delayed) {
    delay(core, taken, target, op->pc + 4);
    return next(core, op);
  }
  core.pc = taken ? target : op->pc + 1;
  return leave(op, taken);
}

bool against_recording(const Op& op, bool taken) { return op.direction != 2 && taken != (op.direction == 1); }

template <bool relative>
Outcome call(Core& core, const Op* op) {
  const bool taken = holds(core, static_cast<Condition>(op->selector));
  if (against_recording(*op, taken)) return {op, Exit::other_way};
  if (!taken) {
    core.pc = op->pc + 1;
    return leave(op, false);
  }
  const Address target = target_of(core, *op, relative);
  const Window& window = op->access[0];
  const Address top = core.r[reg::SP] + 1;
  if (top - window.base >= window.words) [[unlikely]]
    return miss_write(core, op, 0, top, op->pc + 1);
  core.r[reg::SP] = top;
  Place<Kind::direct, 0> place;
  place.formed.address = top;
  if (place.write(*op, op->pc + 1)) code_written(core, top);
  core.pc = target;
  return leave(op, true);
}

template <bool relative>
Outcome link_and_jump(Core& core, const Op* op) {
  const bool taken = holds(core, static_cast<Condition>(op->selector));
  delay(core, taken, target_of(core, *op, relative), op->pc + 4);
  if (taken) core.r[reg::R11] = op->pc + 4;
  return next(core, op);
}

template <bool from_interrupt, bool delayed>
Outcome return_from(Core& core, const Op* op) {
  const bool taken = holds(core, static_cast<Condition>(op->selector));
  if (against_recording(*op, taken)) return {op, Exit::other_way};
  if (!taken) {
    if constexpr (delayed) {
      delay(core, false, 0, op->pc + 4);
      return next(core, op);
    }
    core.pc = op->pc + 1;
    return leave(op, false);
  }
  const Window& window = op->access[0];
  const Address top = core.r[reg::SP];
  if (top - window.base >= window.words) [[unlikely]]
    return miss(core, op, 0, top);
  core.r[reg::SP] = top - 1;
  const Address target = window.data[top - window.base];
  if constexpr (from_interrupt) {
    const Word modes = core.modes & ~(st::GIE | st::CF);
    core.modes = modes | (core.modes & st::PGIE ? st::GIE : 0u) | (core.modes & st::PCF ? st::CF : 0u);
    core.attention = true;
  }
  if constexpr (delayed) {
    delay(core, true, target, op->pc + 4);
    return next(core, op);
  }
  core.pc = target;
  return leave(op, true);
}

Outcome trap(Core& core, const Op* op) {
  const bool taken = holds(core, static_cast<Condition>(op->selector));
  if (against_recording(*op, taken)) return {op, Exit::other_way};
  if (!taken) {
    core.pc = op->pc + 1;
    return leave(op, false);
  }
  Place<Kind::direct, 0> stack;
  Place<Kind::direct, 1> vector;
  stack.formed.address = core.r[reg::SP] + 1;
  vector.formed.address = (core.tvtp & choices::vector_table_mask) + op->immediate;
  if (!stack.met(*op)) [[unlikely]]
    return miss_write(core, op, 0, stack.formed.address, op->pc + 1);
  if (!vector.met(*op)) [[unlikely]]
    return miss(core, op, 1, vector.formed.address);
  core.r[reg::SP] = stack.formed.address;
  const bool code = stack.write(*op, op->pc + 1);
  core.pc = vector.read(*op);
  enter_handler(core);
  if (code) code_written(core, stack.formed.address);
  return leave(op, true);
}

Outcome late_trap(Core& core, const Op* op) {
  const bool taken = holds(core, static_cast<Condition>(op->selector));
  if (against_recording(*op, taken)) return {op, Exit::other_way};
  Place<Kind::direct, 0> vector;
  vector.formed.address = (core.tvtp & choices::vector_table_mask) + op->immediate;
  if (taken && !vector.met(*op)) [[unlikely]]
    return miss(core, op, 0, vector.formed.address);
  delay(core, taken, taken ? vector.read(*op) : 0, op->pc + 4);
  if (taken) {
    core.r[reg::R11] = op->pc + 4;
    enter_handler(core);
  }
  return next(core, op);
}

template <bool relative, bool delayed>
Outcome repeat_block(Core& core, const Op* op) {
  core.r[reg::RE] = target_of(core, *op, relative);
  if constexpr (delayed) {
    core.r[reg::RS] = op->pc + 4;
    delay(core, false, 0, op->pc + 4);
    core.delay_repeat = true;
    return next(core, op);
  }
  core.r[reg::RS] = op->pc + 1;
  core.modes |= st::RM;
  core.repeat_single = 0;
  core.pc = op->pc + 1;
  return leave(op, false);
}

template <Kind kind>
Outcome repeat_single(Core& core, const Op* op) {
  Place<kind, 0> count;
  count.form(core, *op);
  if (!count.met(*op)) [[unlikely]]
    return miss(core, op, 0, count.formed.address);
  count.update(core, *op);
  core.r[reg::RC] = count.integer(core, *op, op->src1);
  core.r[reg::RS] = core.r[reg::RE] = op->pc + 1;
  core.modes |= st::RM;
  core.repeat_single = 1;
  core.pc = op->pc + 1;
  return leave(op, false);
}

template <Kind kind>
Outcome acknowledge(Core& core, const Op* op) {
  Place<kind, 0> place;
  place.form(core, *op);
  if (!place.met(*op)) [[unlikely]]
    return miss(core, op, 0, place.formed.address);
  place.update(core, *op);
  return next(core, op);
}

template <bool floating>
Outcome push(Core& core, const Op* op) {
  Place<Kind::direct, 0> top;
  top.formed.address = core.r[reg::SP] + 1;
  // SP changes before the register is read: PUSH SP stores the new value, as an address update would (c40-isa.md 3.9).
  const Word value = floating              ? float40::to_single({core.e[op->src1], core.r[op->src1]})
                     : op->src1 == reg::SP ? top.formed.address
                                           : core.r[op->src1];
  if (!top.met(*op)) [[unlikely]]
    return miss_write(core, op, 0, top.formed.address, value);
  core.r[reg::SP] = top.formed.address;
  return finish_store(core, op, top.write(*op, value), top.formed.address);
}

template <bool floating, bool flags>
Outcome pop(Core& core, const Op* op) {
  Place<Kind::direct, 0> top;
  top.formed.address = core.r[reg::SP];
  if (!top.met(*op)) [[unlikely]]
    return miss(core, op, 0, top.formed.address);
  const Word word = top.read(*op);
  --core.r[reg::SP];
  if constexpr (floating) {
    const Float40 value = choices::popf_keeps_bits ? float40::from_single_raw(word) : float40::from_single(word);
    set_float(core, float40::load(value).flags);
    set_register(core, op->dst, value);
  } else {
    core.r[op->dst] = integer::logic<flags>(core, word);
  }
  return next(core, op);
}

Outcome no_operation(Core& core, const Op* op) { return next(core, op); }

Outcome address_only(Core& core, const Op* op) {
  Place<Kind::indirect, 0> place;
  place.form(core, *op);
  place.update(core, *op);
  return next(core, op);
}

Outcome wait_for_interrupt(Core& core, const Op* op) {
  core.modes |= st::GIE;
  core.idle = true;
  core.attention = true;
  core.pc = op->pc + 1;
  return leave(op, false);
}

Outcome software_interrupt(Core&, const Op* op) { return {op, Exit::trap_out}; }

/// LDEP and LDPE: the expansion register's number is the op's selector.
Outcome from_expansion(Core& core, const Op* op) {
  core.r[op->dst] = op->selector == 0 ? core.ivtp : core.tvtp;
  return next(core, op);
}
Outcome to_expansion(Core& core, const Op* op) {
  (op->selector == 0 ? core.ivtp : core.tvtp) = core.r[op->src1] & choices::vector_table_mask;
  return next(core, op);
}

template <bool relative>
Handler flow_handler(const isa::Row& row, Condition condition) {
  const bool delayed = row.delay != isa::Delay::none;
  switch (row.operation) {
    case Operation::branch:
      switch (row.delay) {
        case isa::Delay::none:
          return with_test(condition, []<class Test>(Test) -> Handler { return &branch<relative, Test>; });
        case isa::Delay::delayed:
          return with_test(condition,
                           []<class Test>(Test) -> Handler { return &branch_delayed<relative, Annul::never, Test>; });
        case isa::Delay::annul_if_true: return &branch_delayed<relative, Annul::if_true>;
        case isa::Delay::annul_if_false: return &branch_delayed<relative, Annul::if_false>;
      }
      return nullptr;
    case Operation::db:
      return with_test(condition, [&]<class Test>(Test) -> Handler {
        return delayed ? &decrement_and_branch<relative, true, Test> : &decrement_and_branch<relative, false, Test>;
      });
    case Operation::call: return &call<relative>;
    case Operation::laj: return &link_and_jump<relative>;
    case Operation::rptb: return delayed ? &repeat_block<relative, true> : &repeat_block<relative, false>;
    default: return nullptr;
  }
}

template <template <Kind> class Pick>
Handler by_kind(Kind kind) {
  switch (kind) {
    case Kind::reg: return Pick<Kind::reg>::handler;
    case Kind::constant: return Pick<Kind::constant>::handler;
    case Kind::direct: return Pick<Kind::direct>::handler;
    case Kind::offset: return Pick<Kind::offset>::handler;
    case Kind::indirect: return Pick<Kind::indirect>::handler;
    default: return nullptr;
  }
}
template <Kind kind>
struct RepeatSingle {
  static constexpr Handler handler = &repeat_single<kind>;
};
template <Kind kind>
struct Acknowledge {
  static constexpr Handler handler = &acknowledge<kind>;
};

}  // namespace

Handler control_handler(const isa::Row& row, Condition condition, Kind a, bool flags) {
  switch (row.operation) {
    case Operation::branch:
    case Operation::db:
    case Operation::call:
    case Operation::laj:
    case Operation::rptb:
      return a == Kind::reg ? flow_handler<false>(row, condition) : flow_handler<true>(row, condition);
    case Operation::rets: return &return_from<false, false>;
    case Operation::reti: return row.delay == isa::Delay::none ? &return_from<true, false> : &return_from<true, true>;
    case Operation::trap: return &trap;
    case Operation::lat: return &late_trap;
    case Operation::rpts: return by_kind<RepeatSingle>(a);
    case Operation::iack: return by_kind<Acknowledge>(a);
    case Operation::push: return &push<false>;
    case Operation::pushf: return &push<true>;
    case Operation::pop: return flags ? &pop<false, true> : &pop<false, false>;
    case Operation::popf: return &pop<true, true>;
    case Operation::nop: return a == Kind::none ? &no_operation : &address_only;
    case Operation::idle:
    case Operation::idle2: return &wait_for_interrupt;
    case Operation::swi: return &software_interrupt;
    case Operation::ldep: return &from_expansion;
    case Operation::ldpe: return &to_expansion;
    default: return nullptr;
  }
}

Outcome end_of_step(Core&, const Op* op) { return {op, Exit::not_taken}; }

Outcome end_of_block(Core& core, const Op* op) {
  core.pc = op->pc;
  return {op, Exit::not_taken};
}

Outcome end_of_delay(Core& core, const Op* op) {
  core.pc = core.delay_target;
  core.delay_slots = 0;
  if (core.delay_repeat) {
    core.delay_repeat = false;
    core.modes |= st::RM;
    core.repeat_single = 0;
  }
  return {op, core.delay_taken ? Exit::taken : Exit::not_taken};
}

// The terminal's constant is the number of ops before it in the block.
Outcome end_of_repeat(Core& core, const Op* op) {
  core.pc = op->pc;
  return {op, Exit::not_taken};
}

Outcome budget_end(Core&, const Op* op) { return {op, Exit::cut}; }

Outcome miss(Core& core, const Op* op, int access, Address address) {
  core.miss_access = static_cast<std::uint8_t>(access);
  core.miss_address = address;
  core.miss_write = false;
  core.miss_value = 0;
  return {op, Exit::miss};
}

Outcome miss_write(Core& core, const Op* op, int access, Address address, Word value) {
  core.miss_access = static_cast<std::uint8_t>(access);
  core.miss_address = address;
  core.miss_write = true;
  core.miss_value = value;
  return {op, Exit::miss};
}

void code_written(Core& core, Address address) {
  if (core.code_writes < core.code_written.size()) core.code_written[core.code_writes++] = address;
  core.attention = true;
}

}  // namespace c40::execute
