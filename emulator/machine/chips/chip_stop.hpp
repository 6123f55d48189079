#pragma once
// The meaning of a chip's stop for a driver that is not a debugger: defined once, for exec, networks and the dock.
#include <stdexcept>

#include "c40/chip/chip.hpp"

namespace machine {

enum class StopMeaning : std::uint8_t {
  limit,          ///< the driver's own limit
  asks_again,     ///< the driver has to compute again how far the chip may run
  breakpoint,     ///< the driver's own breakpoint
  window_access,  ///< before an access to a window; without an answer by the driver it is a fault
  port_access,    ///< before an access to a linked port
  port_wait,      ///< waits for a port without a link: forever, unless the driver gives a word
  fault           ///< the chip cannot continue: fault_of() says why
};

std::string_view name(StopMeaning meaning);

/// Every reason has a meaning; a new reason does not compile without one.
inline StopMeaning meaning(c40::StopInfo::Reason reason) {
  using enum c40::StopInfo::Reason;
  switch (reason) {
    case limit: return StopMeaning::limit;
    case horizon: return StopMeaning::asks_again;
    case breakpoint: return StopMeaning::breakpoint;
    case external_access: return StopMeaning::window_access;
    case port_access: return StopMeaning::port_access;
    case port_wait: return StopMeaning::port_wait;
    case software_interrupt:
    case fault: return StopMeaning::fault;
  }
  throw std::logic_error("a stop without a meaning");
}

/// Why a chip that stopped like this cannot continue. \throws std::logic_error if the stop is not a fault.
c40::Fault fault_of(const c40::Chip& chip, const c40::StopInfo& stop);

}  // namespace machine
