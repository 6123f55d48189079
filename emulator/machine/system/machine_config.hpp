#pragma once
// A machine's configuration, checked and completed.
#include <vector>

#include "machine/system/machine.hpp"

namespace machine {

/// With every field set and the script in order of time. \throws std::invalid_argument that says what is wrong
Config checked(Config config);

/// \throws std::invalid_argument for an event that makes no sense at `now`
void require_sense(const ScriptedEvent& event, Time now, const Config& config);

/// By slot; by bus.
std::vector<Clock> clocks_of_chips(const Config& config);
std::vector<Clock> clocks_of_buses(const Config& config);

}  // namespace machine
