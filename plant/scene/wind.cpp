#include "plant/scene/wind.hpp"

#include <algorithm>
#include <cmath>

#include "plant/numerics/math.hpp"
#include "plant/numerics/noise.hpp"

namespace plant {
namespace {

constexpr double nodes_per_second = 20.0;
constexpr double length_scale = 170.0;  // m, L at 30 m of height
constexpr double lowest = 2e-4;         // Hz: the first band includes everything below
constexpr double highest =
    5.0;  // Hz: faster gusts are smaller than a container; their 2 % of the variance is added to the others

// The share of the variance below f: the integral of Kaimal's spectrum.
double share_below(double f) { return 1.0 - exp(-2.0 / 3.0 * log(1.0 + 6.0 * f)); }

}  // namespace

Wind::Wind(const WindParameters& parameters) : p_(parameters) {
  const auto [s, c] = sin_cos(p_.direction);
  sin_direction_ = s;
  cos_direction_ = c;
  nodes_.fill({-1'000'000'000, 0.0});
  if (p_.gust == 0.0) return;
  const double per_hertz = length_scale / std::fabs(p_.mean);
  const double whole = share_below(highest * per_hertz);
  const double ratio = log(highest / lowest) / static_cast<double>(lines - 1);
  double below = 0.0, share = 0.0;
  for (std::size_t i = 0; i < lines; ++i) {
    const auto k = static_cast<std::int64_t>(i);
    const double above = lowest * exp(ratio * static_cast<double>(i));
    const double until = share_below(above * per_hertz);
    const double u = uniform(p_.seed, Stream::wind_frequency, k);
    const double frequency = below == 0.0 ? u * above : below * exp(u * ratio);
    rate_[i] = 2.0 * std::numbers::pi * frequency;
    phase_[i] = 2.0 * std::numbers::pi * uniform(p_.seed, Stream::wind_phase, k);
    size_[i] = p_.gust * std::sqrt(2.0 * (until - share) / whole);
    below = above;
    share = until;
  }
}

double Wind::node(std::int64_t number) {
  Node& known = nodes_[static_cast<std::size_t>(number & static_cast<std::int64_t>(kept - 1))];
  if (known.number == number) return known.speed;
  const double seconds = static_cast<double>(number) / nodes_per_second;
  double sum = p_.mean;
  for (std::size_t i = 0; i < lines; ++i) sum += size_[i] * cos(rate_[i] * seconds + phase_[i]);
  known = {number, sum};
  return sum;
}

double Wind::speed(double seconds) {
  if (p_.gust == 0.0) return p_.mean;
  const double at = seconds * nodes_per_second;
  const double before = std::floor(at);
  const auto number = static_cast<std::int64_t>(before);
  const double first = node(number);
  return first + (at - before) * (node(number + 1) - first);
}

double Wind::integral(double from, double to) {
  const double before = std::floor(from);
  const auto number = static_cast<std::int64_t>(before);
  const double first = node(number);
  const double slope = node(number + 1) - first;
  return (to - from) * (first + slope * (0.5 * (from + to) - before));
}

double Wind::mean(double from, double to) {
  if (p_.gust == 0.0) return p_.mean;
  double at = from * nodes_per_second;
  const double end = to * nodes_per_second;
  double sum = 0.0;
  while (at < end) {
    const double next = std::min(end, std::floor(at) + 1.0);
    sum += integral(at, next);
    at = next;
  }
  return sum / (end - from * nodes_per_second);
}

std::array<double, 3> Wind::force(double seconds, const std::array<double, 3>& velocity, double yaw, bool container) {
  const double v = speed(seconds);
  const double x = v * cos_direction_ - velocity[0];
  const double y = v * sin_direction_ - velocity[1];
  double area_times_speed = 0.0;
  if (container) {
    const auto [s, c] = sin_cos(yaw);
    area_times_speed =
        p_.side_area * std::fabs(c * y - s * x) + p_.end_area * std::fabs(c * x + s * y);  // |w| |sin|, |w| |cos|
  } else {
    area_times_speed = p_.spreader_area * std::sqrt(x * x + y * y);
  }
  const double scale = 0.5 * air_density * area_times_speed;
  return {scale * x, scale * y, 0.0};
}

}  // namespace plant
