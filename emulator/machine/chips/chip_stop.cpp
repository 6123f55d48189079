#include "machine/chips/chip_stop.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace machine {

std::string_view name(StopMeaning meaning) {
  using enum StopMeaning;
  switch (meaning) {
    case limit: return "limit";
    case asks_again: return "asks_again";
    case breakpoint: return "breakpoint";
    case window_access: return "window_access";
    case port_access: return "port_access";
    case port_wait: return "port_wait";
    case fault: return "fault";
  }
  return {};
}

c40::Fault fault_of(const c40::Chip& chip, const c40::StopInfo& stop) {
  if (stop.fault) return *stop.fault;
  if (stop.reason != c40::StopInfo::Reason::software_interrupt)
    throw std::logic_error(fmt::format("the stop {} is not a fault", name(stop.reason)));
  return {
      .kind = c40::Fault::Kind::software_interrupt,
      .message = fmt::format("{}: SWI calls a debugger, and there is none", name(c40::Fault::Kind::software_interrupt)),
      .pc = chip.pc(),
      .cycle = chip.cycle(),
      .word = chip.peek(chip.pc()),
      .address = chip.pc()};
}

}  // namespace machine
