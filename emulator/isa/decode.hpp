#pragma once
// Strict decoding: each of the 2^32 words is an Instruction or Reserved. Operands have the roles that an executor
// needs, so the executor never looks at the word's bits (c40-isa.md 3, 6, 12).
#include <cstdint>
#include <string_view>
#include <variant>

#include "isa/table.hpp"
#include "isa/types.hpp"

namespace isa {

/// Indirect addressing, bits "modn" (c40-isa.md 3.9). The low three bits are the action, the upper two the kind of
/// offset.
namespace modn {
inline constexpr std::uint8_t plain = 24;         ///< *ARn
inline constexpr std::uint8_t bit_reversed = 25;  ///< *ARn++(IR0)B
enum class Index : std::uint8_t { displacement, IR0, IR1, none };
enum class Action : std::uint8_t {
  add,
  subtract,  ///< *+ARn(x)   *-ARn(x): address ARn +- x, ARn unchanged
  pre_add,
  pre_subtract,  ///< *++ARn(x)  *--ARn(x): address and new ARn are ARn +- x
  post_add,
  post_subtract,  ///< *ARn++(x)  *ARn--(x): address ARn, new ARn is ARn +- x
  post_add_circular,
  post_subtract_circular,  ///< *ARn++(x)% *ARn--(x)%: the same within the circular buffer of BK words
};
constexpr bool is_legal(unsigned m) { return m <= bit_reversed; }
constexpr Index index(unsigned m) {
  return m == plain ? Index::none : m == bit_reversed ? Index::IR0 : static_cast<Index>(m >> 3);
}
/// Not for `plain` and `bit_reversed`.
constexpr Action action(unsigned m) { return static_cast<Action>(m & 7); }
constexpr bool is_circular(unsigned m) { return m < plain && (m & 6) == 6; }
/// Whether the mode changes ARn.
constexpr bool modifies(unsigned m) { return m < plain ? (m & 7) >= 2 : m == bit_reversed; }
}  // namespace modn

/// The byte of the word that holds an indirect operand. If two operands update the same ARn, only J's update is kept
/// (c40-isa.md 3.9).
enum class Slot : std::uint8_t { none, i, j };

struct Operand {
  enum class Kind : std::uint8_t {
    none,
    reg,              ///< `reg`
    direct,           ///< Memory at (DP << 16) | value
    indirect,         ///< Memory at `reg` (an ARn) modified by `modn` and, for modn < 8, the displacement `value`
    immediate_int,    ///< `value`, extended to 32 bits by the instruction's rule
    immediate_float,  ///< `value` holds the 16 bits of a short float (c40-isa.md 2.2)
    expansion,        ///< `value`: 0 IVTP, 1 TVTP
    target,           ///< The address PC + `value`; PC is the instruction's own address
    address,          ///< The address `value` (C3x)
    trap,             ///< Trap number `value`, 0 to 511
  };
  Kind kind = Kind::none;
  Register reg = Register::R0;
  std::uint8_t modn = 0;
  Slot slot = Slot::none;
  std::int32_t value = 0;

  constexpr bool is(Kind k) const { return kind == k; }
  constexpr bool is_memory() const { return kind == Kind::direct || kind == Kind::indirect; }
  constexpr std::uint32_t displacement() const { return static_cast<std::uint32_t>(value); }
  constexpr bool operator==(const Operand&) const = default;
};

/// An instruction is one or two halves:
///
///     row->operation   dst  <- src1, src2
///     row->operation2  dst2 <- src3, src4      (parallel instructions only)
///
/// src1 is the minuend, the value that is shifted, the only source of a unary operation, the register that a store
/// stores, the target of a branch, or the value that LWL, LWR, MB, MH, LDE and LDM merge in (src2 then is the old dst).
/// src2 is the subtrahend, the shift count, or the mask of ANDN. Compares have no dst. A store's dst is its memory
/// operand. DBcond has its counter in dst. PUSH has src1, POP dst.
///
/// Both halves read before either writes. If both write the same place (load || load to one register, store || store to
/// one address), the result of the first half, the one in src1/dst, stays (c40-isa.md 3.10).
struct Instruction {
  const Row* row = nullptr;
  Word word = 0;
  Condition condition = Condition::U;
  Operand src1, src2, dst;
  Operand src3, src4, dst2;
};

/// Branches, calls, returns, traps, repeats and IDLE: not allowed in delay slots, under RPTS or at the end of a block
/// (c40-isa.md 8.2 to 8.4).
bool is_program_control(const Instruction& instruction);

/// A word that is not an instruction of the processor. The hardware's behaviour is undefined.
struct Reserved {
  enum class Reason : std::uint8_t {
    opcode,           ///< No row has this operation and addressing mode.
    reserved_bits,    ///< Bits that must be 0 are set.
    register_class,   ///< A float operand outside R0-R11, an LDA destination that is not an address register, or one of
                      ///< R8 to R11 on the C3x.
    same_register,    ///< LDA from its own destination.
    addressing_mode,  ///< modn of 26 to 31.
    displacement,     ///< A displacement beside an index register.
    condition,        ///< 11 or 21 to 31.
    expansion_register,  ///< Neither IVTP nor TVTP.
  };
  Reason reason = Reason::opcode;
  Word word = 0;
};
std::string_view describe(Reserved::Reason reason);

using Decoded = std::variant<Instruction, Reserved>;

/// Defined for every word.
Decoded decode(Word word, Cpu cpu = Cpu::c40);

}  // namespace isa
