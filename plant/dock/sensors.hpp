#pragma once
// Quantised sensors. Encoders round down to counts, 16384 per motor revolution. The sway sensor has 12 bits over +-10
// degrees, and noise that depends only on the seed and the number of the sample.
#include <cstdint>

#include "plant/numerics/noise.hpp"
#include "plant/parameters/config.hpp"
#include "plant/parameters/device_codes.hpp"

namespace plant {

std::int64_t encoder_counts(double joint_position, const DriveParameters&);
std::int32_t sway_code(double angle, const SensorParameters&, Stream noise, std::int64_t sample);
// Whether a ray of AGV `agv` has no echo; depends only on the seed and the ray's running number.
bool drops(const SensorParameters&, std::size_t agv, std::int64_t ray);
// Ticks of a sampling clock up to a latch: it ticks each `period` latches, the first time at its phase.
std::int64_t ticks_until(const SampleClock&, std::int64_t latch, std::int64_t period);
// The rate of the range sensors' scans, mHz: a scan at each of the AGVs' steps, if they have no rate of their own.
std::int64_t range_millihertz(const SensorParameters&);
// Ticks of a range sensor's clock up to a latch, at exactly this rate.
std::int64_t range_ticks_until(const SensorParameters&, const SampleClock&, std::int64_t latch);

}  // namespace plant
