#pragma once
// The handlers of each group of instructions, by operation and kinds of operands. Null: this form does not exist.
#include "c40/instructions/op.hpp"
#include "isa/table.hpp"

namespace c40::execute {

/// dst <- op(src1, src2) on integers; `flags`: whether the condition flags change.
Handler integer_handler(isa::Operation operation, Kind a, Kind b, bool flags);
Handler integer_store_handler(isa::Operation operation, Kind a, Kind b);

/// The same on floats, and FIX (whose destination may be any register), FLOAT, LDE, LDM, NORM.
Handler float_handler(isa::Operation operation, Kind a, Kind b, bool flags);
Handler float_store_handler(isa::Operation operation, Kind a, Kind b);

/// LDFcond, LDIcond; the condition is the op's selector, too.
Handler conditional_load_handler(bool floating, isa::Condition condition, Kind a);

/// STI, STF, STIK to memory of kind `to`; `from` is reg or constant.
Handler store_handler(bool floating, Kind from, Kind to);
Handler load_load_handler(bool floating);
Handler store_store_handler(bool floating);
/// `product`: the P field; `kind`: the addressing of both operands if it is the same, else indirect.
Handler multiply_add_handler(bool floating, bool subtract, int product, Kind kind);
/// All passes of a repeat of a single float MPYF3 || ADDF3 (P = 0); null unless the instruction accumulates its own
/// product and its addressing is `kind`.
Handler repeated_multiply_add_handler(const Op& op, Kind kind);

/// PUSH, POP, NOP, IACK and everything that changes the PC. `a` is the kind of src1; none for a relative target.
Handler control_handler(const isa::Row& row, isa::Condition condition, Kind a, bool flags);

/// The handler that ends a run of ops.
Outcome end_of_step(Core& core, const Op* op);
Outcome end_of_block(Core& core, const Op* op);
Outcome end_of_delay(Core& core, const Op* op);
Outcome end_of_repeat(Core& core, const Op* op);
Outcome budget_end(Core& core, const Op* op);

}  // namespace c40::execute
