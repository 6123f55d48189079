#pragma once
/// The registers: the state that instructions work on.
#include <array>
#include <cstdint>

#include "c40/values/float40.hpp"
#include "c40/values/types.hpp"

namespace state {
class Visitor;
}

namespace c40 {

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

}  // namespace c40
