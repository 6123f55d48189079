#pragma once
// The dock of a configuration, with nominal clocks.
#include "cmrc/configuration/config.hpp"
#include "plant/parameters/config.hpp"

namespace cmrc {

/// dock.drive_delay_us in latches of the drives: a whole number, which is checked.
double drive_delay_latches(const Config& config);

/// \throws ConfigError for a layout file that cannot be read, or whose dock cannot be
plant::DockConfig nominal_dock_of(const Config& config);

}  // namespace cmrc
