#pragma once
// The machine's topology of a run: a preset of plant-and-bus.md 3.4, overridden by the keys of [topology].
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "machine/system/bus_topology.hpp"

namespace cmrc {

struct Config;

/// Called with the contradicting keys, what is wrong, and what would be right; does not return.
using Contradiction =
    std::function<void(const std::vector<std::string_view>& keys, const std::string& what, const std::string& right)>;

machine::Topology topology_of(const Config& config, const Contradiction& contradiction);
/// For a checked configuration; std::logic_error otherwise.
machine::Topology topology_of(const Config& config);

}  // namespace cmrc
