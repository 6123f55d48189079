#pragma once
/// What could still wake an idle processor: one in IDLE, or in a branch to itself. Used for a single chip and for a
/// network; in a network, links may add more.
#include <string>

#include "c40/chip/chip.hpp"
#include "machine/time/time.hpp"

namespace machine {

/// The next enabled interrupt (IIE) by one of the chip's timers; the greatest number if there is none.
c40::Cycles next_timer_interrupt(const c40::Chip& chip);
/// The next event of a timer for which a DMA channel waits; the greatest number if there is none.
c40::Cycles next_dma_tick(const c40::Chip& chip);
/// A DMA channel that stops at the end of its block waits for a timer that runs: it is at work, and will end.
bool timer_paces_dma(const c40::Chip& chip);
/// A waiting DMA channel would interrupt the processor at its end (IIE, TCC).
bool awaits_dma(const c40::Chip& chip);
/// One of its timers could interrupt the chip.
bool awaits_timer(const c40::Chip& chip);
/// GIE is set; IDLE sets it.
bool can_interrupt(const c40::Chip& chip);
/// Nothing on the chip will take the processor out of IDLE, or out of a branch to itself.
bool rests_forever(const c40::Chip& chip);
/// In IDLE, and nothing on the chip will wake it.
bool sleeps_forever(const c40::Chip& chip);
/// "; DMA channel 3 waits for a word in input FIFO 3 (read of 00100071h) since cycle 40": the channels that are still
/// armed, or nothing.
std::string armed_dma(const c40::Chip& chip);

}  // namespace machine
