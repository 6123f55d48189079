#pragma once
/// Properties of instructions that no document settles, as named constants: change one here and the emulator follows.
/// Choices that are not a yes or no are functions (docs/fidelity.md names every one, with its evidence). Choices about
/// how a word is read are at the top of isa/table.cpp, choices about time in timing_parameters.hpp.
#include "c40/values/types.hpp"

namespace c40::choices {

/// RND clears Z, as on the VC33 board. TI's page lists Z as unaffected.
inline constexpr bool rnd_clears_zero = true;

/// LDF || LDF leaves the mantissa of a zero that is not canonical in the J half's register, as on the VC33 board.
inline constexpr bool j_load_keeps_mantissa = false;

/// POPF loads the word unchanged, even if its exponent is that of zero. Else the zero becomes canonical.
inline constexpr bool popf_keeps_bits = true;

/// Bits 7..0 of FRIEEE's result for +infinity and NaNs: 00h is the greatest single, FFh the greatest number.
inline constexpr Word frieee_saturated_low_bits = 0x00;

/// TOIEEE rounds to the nearest single, as RND does, instead of truncating.
inline constexpr bool toieee_rounds = false;

/// If an integer result overflows to a 32-bit output of 0, Z follows the output. Else Z says that the true result is
/// not 0.
inline constexpr bool zero_follows_output = true;

/// ASH and ASH3 to the left report overflow in V and LV, as TI's C3x pages say and the VC33 board does.
inline constexpr bool ash_reports_overflow = true;

/// LWRct keeps the high ct bytes of dst, as LWLct keeps the low ones. Else they become 0.
inline constexpr bool lwr_keeps_high_bytes = true;

/// DBcond counts even if the condition is false, as TI's text says. The board's simulator does not.
inline constexpr bool db_counts_on_false = true;

/// Entering a trap or an interrupt sets CF. Else CF stays; it is saved in PCF either way.
inline constexpr bool entry_sets_cache_freeze = true;

/// Bits of IVTP and TVTP that exist; the others read 0.
inline constexpr Word vector_table_mask = ~Word{0x1FF};

}  // namespace c40::choices
