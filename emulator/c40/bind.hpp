#pragma once
/// From a decoded instruction to an op: its handler, its operands, what it asks of the pipeline, and how it may stand
/// in a block.
#include "c40/op.hpp"
#include "isa/decode.hpp"

namespace c40 {

/// How the instruction leaves the straight line.
enum class Flow : std::uint8_t {
  straight,
  branch,     ///< leaves at once, either way: Bcond, DBcond, RPTB, RPTS
  directed,   ///< leaves at once; a block holds one direction only: CALLcond, RETxcond, TRAPcond
  delayed,    ///< after three slots
  annulling,  ///< after three slots that may be annulled
  stop        ///< IDLE, SWI
};

struct BoundInstruction {
  Op op;
  Footprint footprint;
  isa::Word word = 0;
  const isa::Row* row = nullptr;
  Flow flow = Flow::straight;
  int taken_cost = 0;  ///< Cost of a standard branch by direction; 0: the pipeline is not emptied.
  int not_taken_cost = 0;
  bool reads_status = false;
  bool writes_status = false;
  bool writes_interrupts = false;  ///< DIE, IIE, IIF
  bool writes_repeat = false;      ///< RS, RE, RC
  bool reads_repeat = false;
  bool dynamic_target = false;  ///< RPTB of a register: RE is known only when it runs
  bool is_nop = false;
  Handler repeated = nullptr;                  ///< Does all passes of a block that is this instruction alone.
  execute::Kind source = execute::Kind::none;  ///< of src1
  int address_updates = 0;                     ///< Operands whose addressing changes an ARn (annulled slots).
};

/// Why a word cannot be executed.
struct Unexecutable {
  std::string_view reason;
  bool reserved;  ///< No instruction at all; else one that is not modelled.
};

/// `set_condition`: ST's SET COND bit. The op's pc is left 0.
std::variant<BoundInstruction, Unexecutable> bind(isa::Word word, bool set_condition);

}  // namespace c40
