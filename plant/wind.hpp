#pragma once
// Wind on the load: a mean and gusts of six frequencies whose phases depend on the seed alone; a function of time, no state.
#include <array>

#include "plant/config.hpp"

namespace plant {

// Speed along its direction at `seconds`, m/s.
double wind_speed(const WindParameters&, double seconds);
// Its mean from one instant to a later one, m/s: exact.
double mean_wind_speed(const WindParameters&, double from, double to);
// Force on the load, N, world axes: 1/2 rho C A v |v|.
std::array<double, 3> wind_force(const WindParameters&, double seconds);

}  // namespace plant
