#include "c40/peripherals/events.hpp"

#include <fmt/format.h>

namespace c40 {

std::string to_text(const PeripheralEvent& event, const std::function<std::string(Address)>& place) {
  const std::string value =
      place && event.kind == PeripheralEvent::Kind::interrupt ? place(event.value) : fmt::format("{:08X}", event.value);
  return fmt::format("{} {} = {}{}", name(event.kind), event.number, value,
                     event.channel >= 0 ? fmt::format(" (DMA {})", event.channel) : "");
}

}  // namespace c40
