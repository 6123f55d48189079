#pragma once
// Whether the drives of a crane can carry a load at rest.
#include <string>

#include "plant/parameters/config.hpp"

namespace plant {

// Motor torque of the hoist that holds a load (kg below the spreader) at rest, N m: m g / (n eta).
double hoist_holding_torque(const CraneParameters&, double load);

// Why the crane cannot carry that load permanently, with the torque that would be needed: a drive's rated torque or its
// brake is too small. Empty: it can.
std::string cannot_hold(const CraneParameters&, double load);

}  // namespace plant
