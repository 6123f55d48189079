#pragma once
// Checks of impossible cranes and docks. Each throws std::invalid_argument with the value and what would be right.
#include <string>

#include "plant/parameters/config.hpp"

namespace plant {

void check(const CraneParameters&);
void check(const AgvParameters&);
void check(const LandingParameters&);
void check(const WindParameters&);
void check(const SensorParameters&);
void check(const Mover&, const std::string& name);
void check(const DockConfig&);
void check_scene(const DockConfig&);  // combinations of values that are valid alone; part of check(const DockConfig&)

// Throws "plant: `what` (got `value`)" if bad.
void refuse(bool bad, const char* what, double value);

}  // namespace plant
