#pragma once
// What must hold of every bus at all times (plant-and-bus.md 3.6). The bus's own counts are compared.
#include <string>
#include <vector>

#include "bus_model/config.hpp"

namespace pci {

class Bus;

/// Sentences that name what is wrong; empty unless the model has a fault. Every clock before `clock` (as of
/// Bus::statistics) has one use. The masters moved as many words as the targets, and as many as there were data phases.
/// Under round robin no master waited longer than (M - 1)(MLT + 16 + 8) clocks for M masters, plus the arbiter's own
/// clocks and one turnaround. This bound does not apply to a bus that was stalled or has a multi-transaction timer.
std::vector<std::string> audit(const Bus& bus, Clocks clock);

}  // namespace pci
