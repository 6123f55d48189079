#pragma once
/// Makes an op from a decoded instruction: its handler, its operands, its demand on the pipeline, and its possible
/// place in a block.
#include "c40/instructions/op.hpp"
#include "isa/decode.hpp"

namespace c40 {

/// How the instruction changes the sequence of instructions.
enum class Flow : std::uint8_t {
  straight,
  branch,     ///< at once, in either direction: Bcond, DBcond, RPTB, RPTS
  directed,   ///< at once; a block contains one direction only: CALLcond, RETxcond, TRAPcond
  delayed,    ///< after three delay slots
  annulling,  ///< after three delay slots that may be annulled
  stop        ///< IDLE, SWI
};

struct BoundInstruction {
  Op op;
  Footprint footprint;
  isa::Word word = 0;
  const isa::Row* row = nullptr;
  Flow flow = Flow::straight;
  int taken_cost = 0;  ///< Cost of a standard branch by direction; 0: the pipeline is not flushed.
  int not_taken_cost = 0;
  bool reads_status = false;
  bool writes_status = false;
  bool writes_interrupts = false;  ///< DIE, IIE, IIF
  bool writes_repeat = false;      ///< RS, RE, RC
  bool reads_repeat = false;
  bool dynamic_target = false;  ///< RPTB of a register: RE is known only at run time
  bool is_nop = false;
  Handler repeated = nullptr;                  ///< Does all passes of a block that consists of this instruction.
  execute::Kind source = execute::Kind::none;  ///< of src1
  int address_updates = 0;                     ///< Operands whose addressing changes an ARn (for annulled slots).
  int last_update = 0;                         ///< The operand whose update counts if two change one ARn: the J byte.
};

/// Why a word cannot be executed.
struct Unexecutable {
  std::string_view reason;
  bool reserved;  ///< Not an instruction; else an instruction that is not modelled.
};

/// `set_condition`: ST's SET COND bit. The op's pc stays 0.
std::variant<BoundInstruction, Unexecutable> bind(isa::Word word, bool set_condition);

}  // namespace c40
