#pragma once
/// What a channel of the DMA coprocessor waits for, as its chip tells those outside.
#include <optional>
#include <string>

#include "c40/types.hpp"

namespace c40 {

/// What a started half waits for: an event that DIE selects, or a FIFO.
struct DmaWait {
  int channel = 0;
  bool auxiliary = false;
  bool write = false;
  Address address = 0;        ///< of the access that waits
  std::optional<Word> event;  ///< its code in DIE; nothing: it waits for the FIFO at `address`
  std::optional<int> port;    ///< whose FIFO decides
  std::optional<int> timer;   ///< whose event it is
  bool interrupts = false;    ///< the processor may be told of the block's end
  Cycles since = 0;
};
/// "DMA channel 3 waits for a word in input FIFO 3 (read of 00100071h)"
std::string describe(const DmaWait& wait);

}  // namespace c40
