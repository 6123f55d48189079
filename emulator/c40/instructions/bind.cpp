#include "c40/instructions/bind.hpp"

#include <algorithm>

#include "c40/instructions/handler_tables.hpp"
#include "isa/hazards.hpp"
#include "isa/operations.hpp"

namespace c40 {
namespace {

using execute::Kind;
using isa::Format;
using isa::Operand;
using isa::Operation;

constexpr std::uint16_t most_displacement = 255;  // of an op; a negative one is above it, as a number without a sign
constexpr std::uint32_t address_registers = 0x1FFF00u;  // AR0-AR7, DP, IR0, IR1, BK, SP

Kind kind_of(const Operand& operand) {
  switch (operand.kind) {
    case Operand::Kind::none: return Kind::none;
    case Operand::Kind::reg: return Kind::reg;
    case Operand::Kind::direct: return Kind::direct;
    case Operand::Kind::indirect: {
      const bool constant =
          operand.modn == isa::modn::plain ||
          (isa::modn::index(operand.modn) == isa::modn::Index::displacement && !isa::modn::modifies(operand.modn));
      return constant ? Kind::offset : Kind::indirect;
    }
    default: return Kind::constant;
  }
}

/// The addressing of a memory operand as an op keeps it.
struct Displaced {
  std::uint8_t modn;
  std::int32_t displacement;
};
Displaced displacement_of(const Operand& operand) {
  using isa::modn::Action;
  if (!operand.is(Operand::Kind::indirect)) return {0, operand.value};
  if (operand.modn == isa::modn::plain) return {0, 0};
  if (isa::modn::index(operand.modn) != isa::modn::Index::displacement) return {operand.modn, 0};
  constexpr std::uint8_t pre = movement::before | movement::updates;
  switch (isa::modn::action(operand.modn)) {
    case Action::add: return {movement::before, operand.value};
    case Action::subtract: return {movement::before, -operand.value};
    case Action::pre_add: return {pre, operand.value};
    case Action::pre_subtract: return {pre, -operand.value};
    case Action::post_add: return {movement::updates, operand.value};
    case Action::post_subtract: return {movement::updates, -operand.value};
    default: return {operand.modn, operand.value};
  }
}

/// Parallel instructions and NOP have handlers for the general indirect form only.
Kind general_kind_of(const Operand& operand) {
  const Kind kind = kind_of(operand);
  return kind == Kind::offset ? Kind::indirect : kind;
}

class Binder {
 public:
  Binder(const isa::Instruction& instruction, bool set_condition)
      : in_(instruction), row_(*instruction.row), set_condition_(set_condition) {}

  BoundInstruction run() {
    out_.word = in_.word;
    out_.row = &row_;
    out_.source = kind_of(in_.src1);
    describe_hazards();
    fill_registers();
    out_.op.selector = row_.conditional() || is_control() ? isa::code(in_.condition) : row_.selector;
    out_.op.handler = row_.parallel() ? parallel() : single();
    return out_;
  }

 private:
  void describe_hazards() {
    const isa::Hazards h = isa::hazards(in_);
    out_.footprint = {h.address_reads & address_registers, h.operand_reads & address_registers,
                      h.execute_writes & address_registers, h.read_writes & address_registers};
    const auto touches = [](isa::RegisterSet set, std::uint8_t code) { return (set >> code & 1u) != 0; };
    const isa::RegisterSet writes = h.execute_writes | h.read_writes | h.decode_writes;
    out_.reads_status = touches(h.operand_reads, reg::ST);
    out_.writes_status = touches(writes, reg::ST);
    out_.writes_interrupts = touches(writes, reg::DIE) || touches(writes, reg::IIE) || touches(writes, reg::IIF);
    out_.writes_repeat = touches(writes, reg::RS) || touches(writes, reg::RE) || touches(writes, reg::RC);
    out_.reads_repeat =
        touches(h.operand_reads, reg::RS) || touches(h.operand_reads, reg::RE) || touches(h.operand_reads, reg::RC);
  }

  void fill_registers() {
    const auto code = [](const Operand& operand) {
      return operand.is(Operand::Kind::reg) ? isa::code(operand.reg) : std::uint8_t{0};
    };
    Op& op = out_.op;
    op.src1 = code(in_.src1);
    op.src2 = code(in_.src2);
    op.src3 = code(in_.src3);
    op.src4 = code(in_.src4);
    op.dst = code(in_.dst);
    op.dst2 = code(in_.dst2);
  }

  void place(std::size_t slot, const Operand& operand, bool general = false) {
    Op& op = out_.op;
    const Kind kind = general ? general_kind_of(operand) : kind_of(operand);
    op.ar[slot] = isa::code(operand.reg);
    const Displaced displaced = displacement_of(operand);
    op.modn[slot] = displaced.modn;
    op.displacement[slot] = static_cast<std::uint16_t>(displaced.displacement);
    if (kind == Kind::indirect) out_.address_updates = static_cast<int>(slot) + 1;
  }

  void constant(const Operand& operand) {
    Word value = static_cast<Word>(operand.value);
    if (operand.is(Operand::Kind::immediate_float))
      value = row_.operation == Operation::ldm ? (value & 0xFFFu) << 20 : float40::short_to_single(value);
    if (operand.is(Operand::Kind::expansion))
      out_.op.selector = static_cast<std::uint8_t>(value);
    else
      out_.op.immediate = value;
  }

  void source(const Operand& operand, std::size_t& slot, bool general) {
    if (operand.is_memory())
      place(slot++, operand, general);
    else if (!operand.is(Operand::Kind::reg) && !operand.is(Operand::Kind::none))
      constant(operand);
  }

  bool follows_flags() const {
    const isa::Register dst = in_.dst.reg;
    if (!in_.dst.is(Operand::Kind::reg)) return true;
    return isa::is_extended(dst) || (set_condition_ && dst != isa::Register::ST);
  }

  bool floating() const { return isa::operation_row(row_.operation).kind == isa::OperationKind::floating; }

  Handler single() {
    switch (row_.format) {
      case Format::store: place(0, in_.dst); return execute::store_handler(floating(), Kind::reg, kind_of(in_.dst));
      case Format::store_constant:
        constant(in_.src1);
        place(0, in_.dst);
        return execute::store_handler(false, Kind::constant, kind_of(in_.dst));
      default: break;
    }
    const bool control = is_control();
    const bool general = row_.operation == Operation::nop;
    std::size_t slot = 0;
    if (row_.operation == Operation::ldpe) out_.op.selector = static_cast<std::uint8_t>(in_.dst.value);
    source(in_.src1, slot, general);
    source(in_.src2, slot, general);
    if (row_.operation == Operation::ldep) out_.op.selector = static_cast<std::uint8_t>(in_.src1.value);
    const Kind a = kind_of(in_.src1), b = kind_of(in_.src2);
    if (row_.operation == Operation::ldf_cond || row_.operation == Operation::ldi_cond)
      return execute::conditional_load_handler(floating(), in_.condition, a);
    if (control) {
      describe_flow();
      return execute::control_handler(row_, in_.condition, in_.src1.is(Operand::Kind::target) ? Kind::none : a,
                                      follows_flags());
    }
    const Kind first = b == Kind::none && is_circular(0) ? Kind::circular : a;
    if (floating()) return execute::float_handler(row_.operation, first, b, follows_flags());
    return execute::integer_handler(row_.operation, first, b, follows_flags());
  }

  Handler parallel() {
    switch (row_.format) {
      case Format::store_store:
        place(0, in_.dst2, true);
        place(1, in_.dst, true);
        return execute::store_store_handler(floating());
      case Format::load_load:
        place(0, in_.src3, true);
        place(1, in_.src1, true);
        return execute::load_load_handler(floating());
      case Format::multiply_add: {
        for (const Operand* operand : {&in_.src1, &in_.src2, &in_.src3, &in_.src4})
          if (operand->is_memory()) place(operand->slot == isa::Slot::j ? 0 : 1, *operand, true);
        const bool subtract = row_.operation2 == Operation::subf || row_.operation2 == Operation::subi;
        if (floating() && !subtract && row_.selector == 0)
          out_.repeated = execute::repeated_multiply_add_handler(out_.op, common_movement());
        return execute::multiply_add_handler(floating(), subtract, row_.selector, common_movement());
      }
      default: {
        place(0, in_.src1.is_memory() ? in_.src1 : in_.src2, true);
        place(1, in_.dst2, true);
        out_.last_update = 1;
        const Kind a = general_kind_of(in_.src1), b = general_kind_of(in_.src2);
        return floating() ? execute::float_store_handler(row_.operation, a, b)
                          : execute::integer_store_handler(row_.operation, a, b);
      }
    }
  }

  /// *ARn++(d)%
  bool is_circular(std::size_t slot) const {
    return out_.op.modn[slot] == static_cast<std::uint8_t>(isa::modn::Action::post_add_circular);
  }

  Kind common_movement() const {
    const Op& op = out_.op;
    if (op.ar[0] == op.ar[1] || row_.selector != 0) return Kind::indirect;
    if (is_circular(0) && is_circular(1)) return Kind::circular;
    const bool post = op.modn[0] == movement::updates && op.modn[1] == movement::updates;
    return post && std::max(op.displacement[0], op.displacement[1]) <= most_displacement ? Kind::post : Kind::indirect;
  }

  bool is_control() const { return isa::operation_row(row_.operation).kind == isa::OperationKind::control; }

  void cost(int taken, int not_taken) {
    out_.taken_cost = taken;
    out_.not_taken_cost = not_taken;
  }

  void describe_flow() {
    using namespace timing;
    switch (row_.operation) {
      case Operation::branch:
        out_.flow = Flow::branch;
        cost(branch_cost, branch_not_taken_cost);
        break;
      case Operation::db:
        out_.flow = Flow::branch;
        cost(decrement_branch_cost, decrement_branch_not_taken_cost);
        break;
      case Operation::call:
        out_.flow = Flow::directed;
        if (row_.conditional())
          cost(conditional_call_cost, conditional_call_not_taken_cost);
        else
          cost(call_cost, call_cost);
        break;
      case Operation::rets:
      case Operation::reti:
        out_.flow = Flow::directed;
        cost(return_cost, return_not_taken_cost);
        break;
      case Operation::trap:
        out_.flow = Flow::directed;
        cost(trap_cost, trap_not_taken_cost);
        break;
      case Operation::rptb:
        out_.flow = Flow::branch;
        out_.dynamic_target = in_.src1.is(Operand::Kind::reg);
        cost(repeat_block_cost, repeat_block_cost);
        break;
      case Operation::rpts:
        out_.flow = Flow::branch;
        cost(repeat_single_cost, repeat_single_cost);
        break;
      case Operation::laj:
      case Operation::lat: out_.flow = Flow::delayed; return;
      case Operation::idle:
      case Operation::idle2:
      case Operation::swi: out_.flow = Flow::stop; return;
      case Operation::nop: out_.is_nop = row_.format == Format::plain; return;
      default: return;
    }
    if (row_.delay == isa::Delay::none) return;
    cost(0, 0);
    out_.flow = row_.delay == isa::Delay::delayed ? Flow::delayed : Flow::annulling;
  }

  const isa::Instruction& in_;
  const isa::Row& row_;
  bool set_condition_;
  BoundInstruction out_{};
};

}  // namespace

std::variant<BoundInstruction, Unexecutable> bind(isa::Word word, bool set_condition) {
  const isa::Decoded decoded = isa::decode(word);
  if (const auto* reserved = std::get_if<isa::Reserved>(&decoded))
    return Unexecutable{isa::describe(reserved->reason), true};
  BoundInstruction bound = Binder(std::get<isa::Instruction>(decoded), set_condition).run();
  if (bound.op.handler == nullptr) return Unexecutable{bound.row->mnemonic, false};
  return bound;
}

}  // namespace c40
