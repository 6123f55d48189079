#pragma once
// The registers and memory words that an instruction reads and writes, for the pipeline model (c40-hardware.md 7.3,
// 7.4).
#include <cstdint>

#include "isa/decode.hpp"

namespace isa {

/// A set of primary registers: bit n is the register of code n.
using RegisterSet = std::uint32_t;
constexpr RegisterSet set_of(Register r) { return RegisterSet{1} << code(r); }

struct Hazards {
  RegisterSet address_reads =
      0;  ///< Used in the decode stage to form addresses: ARn, IRx, BK, DP, SP, DBcond's counter.
  RegisterSet address_updates =
      0;  ///< Changed in the decode stage: ARn by its addressing mode, SP by PUSH, POP, calls, returns.
  RegisterSet operand_reads = 0;   ///< Read as register operands.
  RegisterSet decode_writes = 0;   ///< LDPK's DP.
  RegisterSet read_writes = 0;     ///< LDA's destination.
  RegisterSet execute_writes = 0;  ///< All other register results; includes R11 of LAJ and LAT, RS, RE, RC of the
                                   ///< repeats, the counter of DBcond.
  std::uint8_t memory_reads = 0;   ///< Data words read (0 to 2).
  std::uint8_t memory_writes = 0;  ///< Data words written (0 to 2).
};

Hazards hazards(const Instruction& instruction);

}  // namespace isa
