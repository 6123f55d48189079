#pragma once
// The dock of a configuration, with nominal clocks.
#include "cmrc/configuration/config.hpp"
#include "plant/parameters/config.hpp"

namespace cmrc {

/// \throws ConfigError for a layout file that cannot be read, or whose dock cannot be
plant::DockConfig nominal_dock_of(const Config& config);

}  // namespace cmrc
