#pragma once
// The instruction table: one row per encoding of the TMS320C4x, and of the TMS320C3x. Decoder, disassembler, assembler,
// the Python metadata and the documentation's table all come from these rows (c40-isa.md 3 and 6).
#include <cstdint>
#include <span>
#include <string_view>

#include "isa/operations.hpp"
#include "isa/picture.hpp"
#include "isa/types.hpp"

namespace isa {

/// How the fields of a word become operands in their roles (decode.hpp). "G" is the operand selected by bits 22..21.
enum class Format : std::uint8_t {
  plain,                   ///< No operand: IDLE, SWI, RETScond.
  unary,                   ///< OP G,dst             dst <- op(src1 = G)
  binary,                  ///< OP G,dst             dst <- op(src1 = dst, src2 = G)
  binary_reversed,         ///< OP G,dst             dst <- op(src1 = G, src2 = dst); also: src1 merged into src2
  compare,                 ///< OP G,reg             op(src1 = reg, src2 = G), nothing written
  source,                  ///< OP G                 op(src1 = G)
  store,                   ///< OP reg,G             memory dst <- src1 = reg
  store_constant,          ///< STIK k,G'            memory dst <- src1 = k; here G = 0 is direct, G = 3 is indirect
  register_source,         ///< OP reg               op(src1 = reg)
  register_destination,    ///< OP reg               dst <- op()
  register_both,           ///< OP reg               dst <- op(src1 = dst)
  load_constant,           ///< LDHI k,dst           dst <- op(src1 = k)
  load_page,               ///< LDPK k               DP <- src1 = k
  three_type1,             ///< OP3 src2,src1,dst    dst <- op(src1, src2), register and 8-bit indirect operands
  three_type2,             ///< the same, with *+ARn(5 bits) and 8-bit immediates
  op3_store,               ///< OP3 I,b,a || ST c,J  a <- op(src1 = b, src2 = I); memory dst2 = J <- src3 = c
  op3_store_reversed,      ///< OP3 b,I,a || ST c,J  a <- op(src1 = I, src2 = b); memory dst2 = J <- src3 = c
  op2_store,               ///< OP I,a || ST c,J     a <- op(src1 = I);           memory dst2 = J <- src3 = c
  load_load,               ///< LD I,a || LD J,b     a <- src1 = I; b (dst2) <- src3 = J
  store_store,             ///< ST a,I || ST c,J     memory dst = I <- src1 = a; memory dst2 = J <- src3 = c
  multiply_add,            ///< MPY3 || ADD3/SUB3    d1 <- src1 * src2; d2 (dst2) <- src3 +- src4; `selector` is P
  branch_displacement,     ///< B target             PC <- src1 = relative target; `selector` is added to the field
  branch_register,         ///< B reg                PC <- src1 = reg
  branch_absolute,         ///< B target of the C3x  PC <- src1 = the address itself
  decrement_displacement,  ///< DB ARn,target        as branch_displacement; dst = ARn
  decrement_register,      ///< DB ARn,reg           as branch_register; dst = ARn
  trap,                    ///< TRAP n               src1 = n
  from_expansion,          ///< LDEP exp,dst
  to_expansion,            ///< LDPE src,exp
};

/// The registers that a register field may name.
enum class OperandClass : std::uint8_t {
  none,
  integer,   ///< Any primary register.
  floating,  ///< R0 to R11.
  lda,       ///< AR0-AR7, DP, IR0, IR1, BK, SP.
};

/// How the 16-bit immediate (in three_type2 the 8-bit immediate) is read.
enum class Immediate : std::uint8_t { none, sign, zero, short_float };

/// The classes of c40-isa.md 5.3, and one class for each instruction with rules of its own.
enum class FlagClass : std::uint8_t { none, A, B, L, S, SA, F, G, ieee, normalize, round, multiply_add };

/// What happens to the three instructions after a branch.
enum class Delay : std::uint8_t { none, delayed, annul_if_true, annul_if_false };

/// The pipeline stage in which `dst` is written (c40-isa.md 8.1).
enum class WriteStage : std::uint8_t { execute, read, decode };

/// Legal values of bits 22..21 (G or T), as a set.
using Modes = std::uint8_t;

struct Row {
  std::string_view picture;
  std::string_view mnemonic;   ///< Lower case; '?' stands for the condition's name.
  std::string_view mnemonic2;  ///< Of the second half of a parallel instruction, else empty.
  Operation operation = Operation::none;
  Operation operation2 = Operation::none;
  Format format = Format::plain;
  OperandClass source = OperandClass::none;       ///< Of each source register field.
  OperandClass destination = OperandClass::none;  ///< none: the instruction writes nothing (the field is then 0).
  Immediate immediate = Immediate::none;
  Modes modes = 15;
  FlagClass flags = FlagClass::none;
  std::uint8_t cycles = 1;  ///< Without conflicts.
  std::uint8_t selector =
      0;  ///< Byte or half-word of a part-word instruction, P of a multiply-add, 1 or 3 of a branch.
  Delay delay = Delay::none;
  WriteStage write_stage = WriteStage::execute;
  bool commutative = false;
  bool interlocked = false;  ///< Drives the LOCK pin (c40-isa.md 6.7).
  bool c4x_only = false;
  std::string_view section;  ///< Section of c40-isa.md.
  Picture bits{};            ///< Derived from `picture`.

  constexpr bool has(char field) const { return static_cast<bool>(bits.field(field)); }
  constexpr bool parallel() const { return !mnemonic2.empty(); }
  constexpr bool conditional() const { return has('c'); }
};

/// Every row, in the order of the opcodes of each group. The C3x's rows are the C40's rows that are not `c4x_only`, and
/// the C3x's own forms instead of those that differ.
std::span<const Row> rows(Cpu cpu = Cpu::c40);

}  // namespace isa
