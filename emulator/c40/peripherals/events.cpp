#include "c40/peripherals/events.hpp"

#include <fmt/format.h>

namespace c40 {

std::string to_text(const PeripheralEvent& event) {
  return fmt::format("{} {} = {:08X}{}", name(event.kind), event.number, event.value, event.channel >= 0 ? fmt::format(" (DMA {})", event.channel) : "");
}

}  // namespace c40
