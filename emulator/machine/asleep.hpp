#pragma once
/// What could still wake a processor that has nothing to do: in IDLE, or in a branch to itself. The same for one chip
/// alone and for a network, in which links may bring more.
#include <limits>
#include <string>

#include "c40/chip.hpp"

namespace machine {

/// Later than every cycle.
inline constexpr c40::Cycles no_cycle = std::numeric_limits<c40::Cycles>::max();

/// The next interrupt by a timer of its own that is enabled (IIE); the greatest number if none is to come.
c40::Cycles next_timer_interrupt(const c40::Chip& chip);
/// The next event of a timer that a DMA channel waits for; the greatest number if none is to come.
c40::Cycles next_dma_tick(const c40::Chip& chip);
/// A DMA channel that waits would interrupt it in the end (IIE, TCC).
bool awaits_dma(const c40::Chip& chip);
/// A timer of its own could interrupt it.
bool awaits_timer(const c40::Chip& chip);
/// GIE is set; IDLE sets it.
bool can_interrupt(const c40::Chip& chip);
/// In IDLE, and nothing on the chip will wake it.
bool sleeps_for_ever(const c40::Chip& chip);
/// "; DMA channel 3 waits for a word in input FIFO 3 (read of 00100071h) since cycle 40": channels that are still
/// armed, or nothing.
std::string armed_dma(const c40::Chip& chip);

}  // namespace machine
