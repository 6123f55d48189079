#pragma once
// Random numbers as functions of a seed, a stream and a number, so the order of draws does not matter. Every purpose
// and every axis has its own stream. The stream's number and the sample's number use separate bits of one key, so no
// two of them share a key.
#include <cstdint>

namespace plant {

enum class Stream : std::uint8_t {
  sway_radial,
  sway_tangential,  // sensor noise, by sample
  second_sway_radial,
  second_sway_tangential,
  range_dropout,  // by AGV and ray
  wind_frequency,
  wind_phase,  // by line of the spectrum
  ship_surge,
  ship_sway,
  ship_heave,
  ship_roll,
  ship_pitch,  // phases, by part
};

// Uniform between 0 and 1, both excluded.
double uniform(std::uint64_t seed, Stream, std::int64_t sample);
// Standard normal.
double normal(std::uint64_t seed, Stream, std::int64_t sample);

}  // namespace plant
