#include "plant/sensors.hpp"

#include <algorithm>
#include <cmath>

#include "plant/dock.hpp"
#include "plant/math.hpp"

namespace plant {
namespace {

// splitmix64: a counter's bits well mixed.
std::uint64_t mix(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

double unit(std::uint64_t bits) { return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53; }

}  // namespace

std::int64_t encoder_counts(double joint_position, const DriveParameters& drive) {
  const double turns = joint_position * drive.gear / (2.0 * std::numbers::pi);
  return static_cast<std::int64_t>(std::floor(turns * counts_per_revolution));
}

double noise(std::uint64_t seed, int axis, std::int64_t sample) {
  const std::uint64_t base = mix(mix(seed) ^ (2 * static_cast<std::uint64_t>(sample) + static_cast<std::uint64_t>(axis)));
  const double radius = std::sqrt(-2.0 * log(unit(base)));
  return radius * cos(2.0 * std::numbers::pi * unit(mix(base)));
}

bool drops(const SensorParameters& p, std::size_t agv, std::int64_t ray) {
  if (p.range_dropout <= 0.0) return false;
  return unit(mix(mix(p.seed ^ 0x52414E4745ULL) ^ mix(static_cast<std::uint64_t>(ray) * 16 + agv))) < p.range_dropout;
}

std::int64_t ticks_until(const SampleClock& clock, std::int64_t latch, std::int64_t period) {
  __extension__ using Wide = __int128;
  constexpr Wide million = 1'000'000;
  const Wide since = (Wide{latch} * latch_period.count() - clock.phase_ps) * (million + clock.ppm);
  const Wide length = Wide{period} * latch_period.count() * million;
  const Wide ticks = since / length;
  return static_cast<std::int64_t>(ticks * length > since ? ticks - 1 : ticks);
}

std::int64_t range_latches(const SensorParameters& p) {
  if (p.range_rate <= 0.0) return agv_latches;
  return std::max<std::int64_t>(1, std::llround(1.0 / (p.range_rate * agv_latches * latch_seconds))) * agv_latches;
}

std::int32_t sway_code(double angle, const SensorParameters& p, int axis, std::int64_t sample) {
  const double seen = angle + (p.sway_noise > 0.0 ? p.sway_noise * noise(p.seed, axis, sample) : 0.0);
  return static_cast<std::int32_t>(std::clamp(std::floor(seen / p.sway_range * 2048.0), -2048.0, 2047.0));
}

}  // namespace plant
