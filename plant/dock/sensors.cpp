#include "plant/dock/sensors.hpp"

#include <algorithm>
#include <cmath>

#include "plant/dock/dock.hpp"
#include "plant/numerics/math.hpp"

namespace plant {
std::int64_t encoder_counts(double joint_position, const DriveParameters& drive) {
  const double turns = joint_position * drive.gear / (2.0 * std::numbers::pi);
  return static_cast<std::int64_t>(std::floor(turns * counts_per_revolution));
}

bool drops(const SensorParameters& p, std::size_t agv, std::int64_t ray) {
  if (p.range_dropout <= 0.0) return false;
  return uniform(p.seed, Stream::range_dropout, ray * 16 + static_cast<std::int64_t>(agv)) < p.range_dropout;
}

std::int64_t ticks_until(const SampleClock& clock, std::int64_t latch, std::int64_t period) {
  const auto floor_divide = [](auto since, auto length) {
    const auto ticks = since / length;
    return static_cast<std::int64_t>(ticks * length > since ? ticks - 1 : ticks);
  };
  const std::int64_t since = latch * latch_period.count() - clock.phase_ps, length = period * latch_period.count();
  if (clock.ppm == 0) return floor_divide(since, length);
  __extension__ using Wide = __int128;
  constexpr Wide million = 1'000'000;
  return floor_divide(since * (million + clock.ppm), length * million);
}

std::int64_t range_latches(const SensorParameters& p) {
  if (p.range_rate <= 0.0) return agv_latches;
  return std::max<std::int64_t>(1, std::llround(1.0 / (p.range_rate * agv_latches * latch_seconds))) * agv_latches;
}

std::int32_t sway_code(double angle, const SensorParameters& p, Stream stream, std::int64_t sample) {
  const double seen = angle + (p.sway_noise > 0.0 ? p.sway_noise * normal(p.seed, stream, sample) : 0.0);
  const double code = std::floor(seen / p.sway_range * sway_codes);
  return static_cast<std::int32_t>(std::clamp(code, -1.0 * sway_codes, sway_codes - 1.0));
}

}  // namespace plant
