#pragma once
// Quantised sensors. Encoders floor to counts, 16384 to a motor revolution; the sway sensor has 12 bits over +-10
// degrees and a noise that depends on nothing but the seed and the number of the sample.
#include <cstdint>

#include "plant/numerics/noise.hpp"
#include "plant/parameters/config.hpp"
#include "plant/parameters/device_codes.hpp"

namespace plant {

std::int64_t encoder_counts(double joint_position, const DriveParameters&);
std::int32_t sway_code(double angle, const SensorParameters&, Stream noise, std::int64_t sample);
// Whether a ray of AGV `agv` brings no echo; depends on the seed and the ray's running number alone.
bool drops(const SensorParameters&, std::size_t agv, std::int64_t ray);
// Ticks of a sampling clock up to a latch: it ticks each `period` latches, the first time at its phase.
std::int64_t ticks_until(const SampleClock&, std::int64_t latch, std::int64_t period);
// Latches from a scan of the range sensors to the next.
std::int64_t range_latches(const SensorParameters&);

}  // namespace plant
