#pragma once
/// One predecoded instruction, and the state that instructions work on.
///
/// Handlers follow each other by tail calls: each does its work and then calls the next op's handler. A handler that
/// cannot continue (a guard fails, the block ends) returns. A handler changes nothing before all its guards have
/// passed, so any instruction can be left and repeated by the exact engine, which runs the same handlers one at a time.
#include <array>
#include <cstdint>

#include "c40/pipeline/timing.hpp"
#include "c40/values/float40.hpp"
#include "c40/values/types.hpp"
#include "isa/types.hpp"

namespace state {
class Visitor;
}

namespace c40 {

struct Op;
struct Core;

/// Why a run of handlers returned.
enum class Exit : std::uint64_t {
  not_taken,   ///< the end of the block without a branch (or with a branch not taken)
  taken,       ///< the end of the block, at a branch's target
  miss,        ///< an access failed its guard: nothing of `at` was done
  left_after,  ///< `at` was done; the next instruction must be looked up again
  trap_out,    ///< SWI: nothing of `at` was done
  cut          ///< the budget does not cover `at`: nothing of it was done
};
struct Outcome {
  const Op* at;
  Exit exit;
};
using Handler = Outcome (*)(Core&, const Op*);

/// The memory of one access of an op when it was recorded: guard, fast path and timing in one.
struct Window {
  Word* data = nullptr;
  Address base = 0;
  Word words = 0;
};

/// The addressing of an indirect operand with a displacement, which an op keeps with its sign: two bits.
namespace movement {
inline constexpr std::uint8_t before = 1;   ///< the address is ARn + displacement, not ARn
inline constexpr std::uint8_t updates = 2;  ///< ARn + displacement is the new ARn
inline constexpr std::uint8_t end = 4;
}  // namespace movement

struct Op {
  Handler handler = nullptr;
  std::array<Window, 2> access{};
  Address pc = 0;
  Word immediate = 0;  ///< Constant, branch offset, trap number.
  std::array<std::uint16_t, 2> displacement{};
  std::uint8_t dst = 0, src1 = 0, src2 = 0, src3 = 0, src4 = 0, dst2 = 0;
  std::array<std::uint8_t, 2> ar{};
  std::array<std::uint8_t, 2> modn{};  ///< A movement, or, from movement::end on, the instruction's own modn
  std::uint8_t selector = 0;           ///< Condition, byte or half-word.
  std::uint8_t direction = 2;  ///< In a block: the direction (0, 1) that a conditional call, return or trap must take.
};
static_assert(sizeof(Op) == 64);

/// Register codes as indices.
namespace reg {
inline constexpr std::uint8_t AR0 = 8, DP = 16, IR0 = 17, IR1 = 18, BK = 19, SP = 20, ST = 21, DIE = 22, IIE = 23,
                              IIF = 24, RS = 25, RE = 26, RC = 27, R11 = 31;
}  // namespace reg

/// The program's state. Mantissas and exponents are separate; each flag of ST is kept in the form that is fastest to
/// set.
struct Core {
  std::array<Word, 32> r{};          ///< Primary register file, bits 31..0; ST only during a read or write of it.
  std::array<std::int32_t, 32> e{};  ///< Exponents of R0 to R11, at their codes.
  Word negative = 0;                 ///< N is bit 31
  Word zero = 1;                     ///< Z is (zero == 0)
  Word carry = 0;                    ///< C is bit 0
  Word range = 0;                    ///< V and UF, at their places
  Word sticky = 0;                   ///< LV and LUF, at their places
  Word modes = 0;                    ///< All other bits of ST
  Address pc = 0;
  Address delay_target = 0;
  std::uint32_t delay_slots = 0;  ///< Instructions until a delayed branch takes effect; 0: no branch is pending
  bool delay_taken = false;
  bool delay_repeat = false;  ///< The pending branch is RPTBD: RM is set at its end
  bool annul = false;         ///< The pending slots are annulled
  bool idle = false;
  std::uint8_t repeat_single = 0;  ///< RPTS: 1 before the first execution, 2 after (no further fetch)
  Word ivtp = 0, tvtp = 0;

  // Not part of the state: values from handlers to the engine.
  std::uint32_t loop_left = 0;  ///< Further passes through a repeated block
  Address miss_address = 0;
  Word miss_value = 0;
  std::uint8_t miss_access = 0;
  bool miss_write = false;
  bool attention = false;  ///< A change that affects interrupts, or a write to code
  std::uint8_t code_writes = 0;
  std::array<Address, 2> code_written{};

  void list_state(state::Visitor& list);
  Word status() const {
    return modes | sticky | range | (carry & st::C) | (zero == 0 ? st::Z : 0u) | (negative >> 31) * st::N;
  }
  /// The bits of ST as given, without the rule for RM.
  void set_status(Word value) {
    constexpr Word flags = st::C | st::V | st::Z | st::N | st::UF | st::LV | st::LUF;
    modes = value & 0xFFFFu & ~flags & ~st::CC;
    carry = value & st::C;
    zero = ~value & st::Z;
    negative = value << 28;
    range = value & (st::V | st::UF);
    sticky = value & (st::LV | st::LUF);
  }
};

namespace execute {

/// c40-isa.md 3 and 6: where an operand is.
enum class Kind : std::uint8_t {
  none,
  reg,
  constant,
  direct,
  offset,    ///< *+ARn(d), *-ARn(d), *ARn: ARn does not change
  indirect,  ///< any form
  post,      ///< *ARn++(d), for the multiply-adds
  circular   ///< *ARn++(d)%, for the multiply-adds and for operations with one source
};
constexpr bool is_memory(Kind k) { return k >= Kind::direct; }
constexpr bool updates_register(Kind k) { return k >= Kind::indirect; }

[[gnu::cold, gnu::noinline]] Outcome miss(Core& core, const Op* op, int access, Address address);
[[gnu::cold, gnu::noinline]] Outcome miss_write(Core& core, const Op* op, int access, Address address, Word value);
[[gnu::cold, gnu::noinline]] void code_written(Core& core, Address address);

inline Outcome next(Core& core, const Op* op) { return op[1].handler(core, op + 1); }

}  // namespace execute
}  // namespace c40
