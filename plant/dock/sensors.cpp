#include "plant/dock/sensors.hpp"

#include <algorithm>
#include <cmath>

#include "plant/dock/dock.hpp"
#include "plant/numerics/math.hpp"

namespace plant {
namespace {

__extension__ using Wide = __int128;
constexpr Wide million = 1'000'000;

std::int64_t floor_divide(auto since, auto length) {
  const auto ticks = since / length;
  return static_cast<std::int64_t>(ticks * length > since ? ticks - 1 : ticks);
}

}  // namespace

std::int64_t encoder_counts(double joint_position, const DriveParameters& drive) {
  const double turns = joint_position * drive.gear / (2.0 * std::numbers::pi);
  return static_cast<std::int64_t>(std::floor(turns * counts_per_revolution));
}

bool drops(const SensorParameters& p, std::size_t agv, std::int64_t ray) {
  if (p.range_dropout <= 0.0) return false;
  return uniform(p.seed, Stream::range_dropout, ray * 16 + static_cast<std::int64_t>(agv)) < p.range_dropout;
}

std::int64_t ticks_until(const SampleClock& clock, std::int64_t latch, std::int64_t period) {
  const std::int64_t since = latch * latch_period.count() - clock.phase_ps, length = period * latch_period.count();
  if (clock.ppm == 0) return floor_divide(since, length);
  return floor_divide(Wide{since} * (million + clock.ppm), Wide{length} * million);
}

std::int64_t range_millihertz(const SensorParameters& p) {
  constexpr std::int64_t of_a_step = 1'000'000'000'000'000 / (agv_latches * latch_period.count());
  return p.range_rate > 0.0 ? std::llround(p.range_rate * 1000.0) : of_a_step;
}

std::int64_t range_ticks_until(const SensorParameters& p, const SampleClock& clock, std::int64_t latch) {
  if (p.range_rate <= 0.0) return ticks_until(clock, latch, agv_latches);
  constexpr Wide tick = 1'000'000'000'000'000;  // ps at 1 mHz
  const Wide since = latch * latch_period.count() - clock.phase_ps;
  return floor_divide(since * range_millihertz(p) * (million + clock.ppm), tick * million);
}

std::int32_t sway_code(double angle, const SensorParameters& p, Stream stream, std::int64_t sample) {
  const double seen = angle + (p.sway_noise > 0.0 ? p.sway_noise * normal(p.seed, stream, sample) : 0.0);
  const double code = std::floor(seen / p.sway_range * sway_codes);
  return static_cast<std::int32_t>(std::clamp(code, -1.0 * sway_codes, sway_codes - 1.0));
}

}  // namespace plant
