#include "machine/chips/chip_runner.hpp"

#include <stdexcept>

namespace machine {

void ChipRunner::run_chip(c40::Chip& chip) {
  while (const std::optional<Span> next = span()) {
    const c40::StopInfo& stop = next->one_instruction ? chip.step() : chip.run_until(next->limit, next->known);
    if (!continues(chip, stop)) return;
  }
}

bool ChipRunner::continues(const c40::Chip& chip, const c40::StopInfo& stop) {
  switch (meaning(stop.reason)) {
    case StopMeaning::limit: return at_limit();
    case StopMeaning::asks_again: return asks_again();
    case StopMeaning::breakpoint: return at_breakpoint();
    case StopMeaning::window_access: return window_access(stop.access);
    case StopMeaning::port_access: return port_access(stop.port);
    case StopMeaning::port_wait: return port_wait(stop.port);
    case StopMeaning::fault: return faulted(fault_of(chip, stop));
  }
  throw std::logic_error("a stop without a meaning");
}

}  // namespace machine
