#pragma once
/// One predecoded instruction.
///
/// Handlers follow each other by tail calls: each does its work and then calls the next op's handler. A handler that
/// cannot continue (a guard fails, the block ends) returns. A handler changes nothing before all its guards have
/// passed, so any instruction can be left and repeated by the exact engine, which runs the same handlers one at a time.
#include <array>
#include <cstdint>

#include "c40/pipeline/timing.hpp"
#include "c40/values/core.hpp"
#include "c40/values/types.hpp"
#include "isa/types.hpp"

namespace c40 {

struct Op;

/// Why a run of handlers returned.
enum class Exit : std::uint64_t {
  not_taken,   ///< the end of the block without a branch (or with a branch not taken)
  taken,       ///< the end of the block, at a branch's target
  miss,        ///< an access failed its guard: nothing of `at` was done
  other_way,   ///< a condition is not as it was recorded: nothing of `at` was done, and no access is known
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
