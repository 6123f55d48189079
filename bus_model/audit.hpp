#pragma once
// What must hold of every bus at all times (plant-and-bus.md 3.6), from its own counts.
#include <string>
#include <vector>

#include "bus_model/config.hpp"

namespace pci {

class Bus;

/// Sentences, empty unless the model has a fault: every clock before `clock` (as of Bus::statistics) has one use; what
/// masters moved, targets and data phases moved; under round robin nobody waited longer than (M - 1)(MLT + 16 + 8)
/// clocks for M masters, the arbiter's own clocks and one turnaround apart, unless it was stalled or has a
/// multi-transaction timer.
std::vector<std::string> audit(const Bus& bus, Clocks clock);

}  // namespace pci
