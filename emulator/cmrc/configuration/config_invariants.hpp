#pragma once

#include <functional>
#include <map>
#include <string>

#include "cmrc/configuration/config.hpp"

namespace cmrc {

/// Checks the invariants of plant-and-bus.md 4.5, and that settings do not exclude each other. Throws ConfigError, with
/// the place in `origins` of an involved key, if one of them was set.
void check_invariants(const Config& config, std::map<std::string, Origin, std::less<>> origins);

}  // namespace cmrc
