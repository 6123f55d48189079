#pragma once
/// Events of a chip's peripherals at the time when they happen. Links have events of their own (link.hpp).
#include <functional>
#include <string>
#include <string_view>

#include "c40/values/types.hpp"

namespace c40 {

struct PeripheralEvent {
  enum class Kind : std::uint8_t {
    port_write,  ///< a word went into the output FIFO of port `number`
    port_read,   ///< a word was read from the input FIFO of port `number`
    dma_start,   ///< a half of channel `number` was started, or both; `value` is its control word
    dma_end,     ///< a block of channel `number` has ended; `value` is 1 for the auxiliary half
    timer,       ///< TINT of timer `number`
    interrupt  ///< the interrupt with offset `number` in the vector table was taken; `value` is the interrupted address
  };
  Kind kind = Kind::port_write;
  Cycles cycle = 0;
  int number = 0;
  Word value = 0;
  int channel = -1;  ///< for port_write and port_read: the DMA channel that did it; -1: the processor
};

constexpr std::string_view name(PeripheralEvent::Kind kind) {
  constexpr std::array<std::string_view, 6> names{"port_write", "port_read", "dma_start",
                                                  "dma_end",    "timer",     "interrupt"};
  return names[static_cast<std::size_t>(kind)];
}

/// "port_write 3 = 0000002A (DMA 1)"
/// \param place names the interrupted address; without it, the address is eight digits
std::string to_text(const PeripheralEvent& event, const std::function<std::string(Address)>& place = {});

class PeripheralSink {
 public:
  virtual ~PeripheralSink() = default;
  virtual void happened(const PeripheralEvent& event) = 0;
};

/// A sink that may be absent.
struct PeripheralNotifier {
  PeripheralSink* sink = nullptr;
  void operator()(const PeripheralEvent& event) const {
    if (sink != nullptr) sink->happened(event);
  }
};

}  // namespace c40
