#pragma once
/// The memory interface control registers GMICR and LMICR (c40-hardware.md 1.4).
#include "c40/peripherals/fields.hpp"

namespace c40::memory_interface {

inline constexpr Field CE0{"CE0", 0, 1, FieldAccess::read_only, "level of the pin"};
inline constexpr Field CE1{"CE1", 1, 1, FieldAccess::read_only, "level of the pin"};
inline constexpr Field DE{"DE", 2, 1, FieldAccess::read_only, "level of the pin"};
inline constexpr Field AE{"AE", 3, 1, FieldAccess::read_only, "level of the pin"};
inline constexpr Field STRB0_SWW{"STRB0 SWW", 4, 2, FieldAccess::read_write,
                                 "ready from 00 the pin, 01 the counter, 10 either, 11 both"};
inline constexpr Field STRB1_SWW{"STRB1 SWW", 6, 2, FieldAccess::read_write, "the same of STRB1"};
inline constexpr Field STRB0_WTCNT{"STRB0 WTCNT", 8, 3, FieldAccess::read_write, "software wait states of STRB0"};
inline constexpr Field STRB1_WTCNT{"STRB1 WTCNT", 11, 3, FieldAccess::read_write, "software wait states of STRB1"};
inline constexpr Field STRB0_PAGESIZE{"STRB0 PAGESIZE", 14, 5, FieldAccess::read_write, "v: pages of 2^(v+1) words"};
inline constexpr Field STRB1_PAGESIZE{"STRB1 PAGESIZE", 19, 5, FieldAccess::read_write, "the same of STRB1"};
inline constexpr Field STRB_ACTIVE{"STRB ACTIVE", 24, 5, FieldAccess::read_write,
                                   "v: the first 2^(v+1) words of the bus are STRB0's"};
inline constexpr Field STRB_SWITCH{"STRB SWITCH", 29, 1, FieldAccess::read_write,
                                   "1: a cycle between reads that change strobe"};

}  // namespace c40::memory_interface
