#pragma once
// All numbers of the timing model that the documents do not give exactly, in one place (docs/fidelity.md).

namespace c40::timing {

/// Standard branches: cycles from the branch's slot to the first instruction at the new address (c40-hardware.md 7.2).
inline constexpr int branch_cost = 4;
inline constexpr int branch_not_taken_cost = 4;            // (unverified)
inline constexpr int decrement_branch_cost = 4;            // (unverified number)
inline constexpr int decrement_branch_not_taken_cost = 4;  // (unverified)
inline constexpr int call_cost = 4;
inline constexpr int conditional_call_cost = 5;            // (unverified)
inline constexpr int conditional_call_not_taken_cost = 5;  // (unverified)
inline constexpr int return_cost = 4;
inline constexpr int return_not_taken_cost = 4;  // (unverified)
inline constexpr int trap_cost = 5;              // (unverified)
inline constexpr int trap_not_taken_cost = 5;    // (unverified)
inline constexpr int repeat_block_cost = 4;
inline constexpr int repeat_single_cost = 4;

/// From recognition of an interrupt to the first instruction of the service routine, zero-wait code, stack and table
/// (c40-hardware.md 5.5) (unverified).
inline constexpr int interrupt_entry_cost = 8;

/// Accesses per cycle of an on-chip block (c40-hardware.md 7.4); of the boot ROM it is the C3x figure (unverified).
inline constexpr int block_ports = 2;

/// An external write occupies its bus for this many cycles plus its wait states; a read takes 1 + waits.
inline constexpr int external_write_cycles = 2;
/// A read directly after a write on the same external bus takes one cycle more.
inline constexpr int read_after_write_cycles = 1;
/// The peripheral bus takes one access per cycle, in either direction (unverified).
inline constexpr int peripheral_write_cycles = 1;
/// With STRB SWITCH set, a read directly after a read on the other strobe of the bus takes this many cycles more
/// (unverified).
inline constexpr int strobe_switch_cycles = 1;
/// Cycles per tick of a timer's internal clock, H1/2 (c40-hardware.md 4).
inline constexpr int timer_tick_cycles = 2;
/// From the write that starts a DMA channel until its first access may begin (c40-hardware.md 3) (unverified).
inline constexpr int dma_start_cycles = 1;
/// Cycles that the DMA takes to move a word of a list into its register, after reading it (c40-hardware.md 3.7)
/// (unverified).
inline constexpr int dma_list_write_cycles = 1;
/// Longest wait states, and longest further wait states for another page, that a region of a board may declare.
inline constexpr int max_region_waits = 15;

}  // namespace c40::timing
