#pragma once
// What no crane or dock can be. Each throws std::invalid_argument that names the value and says what would be right.
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
void check_scene(const DockConfig&);  // of things that are right each for itself; part of check(const DockConfig&)

// Throws "plant: `what` (got `value`)" if bad.
void refuse(bool bad, const char* what, double value);

}  // namespace plant
