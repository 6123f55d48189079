#pragma once
// What a chip's stop means to who drives chips and is no debugger: said once, for exec, networks and the dock.
#include "c40/chip.hpp"

namespace machine {

enum class StopMeaning : std::uint8_t {
  limit,          ///< the driver's own
  asks_anew,      ///< it has to be asked anew how far the chip may run
  breakpoint,     ///< the driver's own
  window_access,  ///< before an access to a window: the driver answers it, or nothing does
  port_access,    ///< before an access to a linked port
  port_wait,      ///< waits for a port with nothing attached: for ever, if the driver does not bring the word
  fault           ///< it cannot go on: fault_of() says why
};

std::string_view name(StopMeaning meaning);

/// Every reason has a meaning; a new one does not compile before it is given one.
StopMeaning meaning(c40::StopInfo::Reason reason);

/// Why a chip that stopped so cannot go on. \throws std::logic_error if the stop means no fault.
c40::Fault fault_of(const c40::Chip& chip, const c40::StopInfo& stop);

}  // namespace machine
