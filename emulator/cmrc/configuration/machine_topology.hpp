#pragma once
// The topology of a run: a preset of plant-and-bus.md 3.4 with the keys of [topology] over it, as the machine wants it.
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "machine/bus_topology.hpp"

namespace cmrc {

struct Config;

/// Told which keys do not fit together, what is wrong, and what would be right; does not return.
using Contradiction =
    std::function<void(const std::vector<std::string_view>& keys, const std::string& what, const std::string& right)>;

machine::Topology topology_of(const Config& config, const Contradiction& contradiction);
/// Of a configuration that has been checked; std::logic_error otherwise.
machine::Topology topology_of(const Config& config);

}  // namespace cmrc
