#pragma once

#include <functional>
#include <map>
#include <string>

#include "cmrc/configuration/config.hpp"

namespace cmrc {

/// The invariants of plant-and-bus.md 4.5 and the settings that exclude each other. Throws ConfigError, which names the
/// place in `origins` of a key involved, if one of them was set.
void check_invariants(const Config& config, std::map<std::string, Origin, std::less<>> origins);

}  // namespace cmrc
