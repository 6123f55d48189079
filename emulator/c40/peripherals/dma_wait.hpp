#pragma once
/// What a DMA channel waits for, in the form that its chip reports to the outside.
#include <optional>
#include <string>

#include "c40/values/types.hpp"

namespace c40 {

/// What a started half waits for: an event that DIE selects, or a FIFO.
struct DmaWait {
  int channel = 0;
  bool auxiliary = false;
  bool write = false;
  Address address = 0;        ///< of the access that waits
  std::optional<Word> event;  ///< the event's code in DIE; nothing: the half waits for the FIFO at `address`
  std::optional<int> port;    ///< the port of the FIFO or event
  std::optional<int> timer;   ///< the timer of the event
  bool interrupts = false;    ///< the end of the block may cause an interrupt
  bool stops = false;         ///< the half stops at the end of the block
  Cycles since = 0;
};
/// "DMA channel 3 waits for a word in input FIFO 3 (read of 00100071h)"
std::string describe(const DmaWait& wait);

}  // namespace c40
