#include "plant/wind.hpp"

#include <cmath>

#include "plant/math.hpp"
#include "plant/sensors.hpp"

namespace plant {
namespace {

constexpr double air = 1.225;  // kg/m3
constexpr std::array frequencies = {0.013, 0.031, 0.067, 0.13, 0.23, 0.41};  // Hz, none a multiple of another
constexpr int wind_axis = 2;   // keeps the phases apart from the sway sensor's noise

}  // namespace

double wind_speed(const WindParameters& p, double seconds) {
  double sum = 0.0;
  if (p.gust > 0.0) {
    for (std::size_t i = 0; i < frequencies.size(); ++i) {
      const double phase = 2.0 * std::numbers::pi * noise(p.seed, wind_axis, static_cast<std::int64_t>(i));
      sum += cos(2.0 * std::numbers::pi * frequencies[i] * seconds + phase);
    }
  }
  return p.mean + p.gust * std::sqrt(2.0 / static_cast<double>(frequencies.size())) * sum;
}

double mean_wind_speed(const WindParameters& p, double from, double to) {
  double sum = 0.0;
  if (p.gust > 0.0) {
    for (std::size_t i = 0; i < frequencies.size(); ++i) {
      const double phase = 2.0 * std::numbers::pi * noise(p.seed, wind_axis, static_cast<std::int64_t>(i));
      const double rate = 2.0 * std::numbers::pi * frequencies[i];
      sum += (sin(rate * to + phase) - sin(rate * from + phase)) / (rate * (to - from));
    }
  }
  return p.mean + p.gust * std::sqrt(2.0 / static_cast<double>(frequencies.size())) * sum;
}

std::array<double, 3> wind_force(const WindParameters& p, double seconds) {
  const double v = wind_speed(p, seconds);
  const double size = 0.5 * air * p.area * v * std::fabs(v);
  const auto [s, c] = sin_cos(p.direction);
  return {size * c, size * s, 0.0};
}

}  // namespace plant
