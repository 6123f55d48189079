#pragma once
// Clock deviations (ruling 40): with run.phase_jitter each oscillator has its own frequency, up to 100 ppm from the
// nominal one, and its own phase. Without it all clocks begin at 0 and have their nominal frequency; so do the chips
// and buses of the ideal run, in which time costs nothing. The ideal run's host timer, sensors and AGV units have the
// run's own clocks.
//
// The drives' 8-kHz latch has no deviation: it is the plant's mesh (ruling 5).
#include <cstdint>
#include <string>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "machine/time/time.hpp"

namespace cmrc {

inline constexpr std::int64_t most_ppm = 100;

/// One oscillator: its nominal clock, and its deviation from it.
struct Oscillator {
  std::string name;             ///< "host timer", "PCI A", "DSP 0", "sway sensor", "range sensor 0", "AGV unit 0"
  std::int64_t hertz, per = 1;  ///< nominal frequency hertz / per
  machine::Skew skew;
};

/// The oscillators of a run.
struct Oscillators {
  Oscillator host;
  std::vector<Oscillator> buses, dsps;  ///< by bus, and by slot
  Oscillator sway;
  std::vector<Oscillator> range;  ///< by AGV; empty if the range sensors follow the AGVs' steps (docs/plant.md)
  std::vector<Oscillator> units;  ///< by AGV

  /// All, in this order.
  std::vector<Oscillator> all() const;
};

/// Whole ppm from -100 to 100, and a phase of whole picoseconds within one period: drawn from run.seed and the
/// oscillator's name alone, so that adding a DSP changes no other clock.
/// \throws ConfigError if a drawn frequency cannot be represented (machine::Clock)
Oscillators oscillators_of(const Config& config);

/// A number from 0 up to 1 that depends on seed, name and count alone.
double unit_draw(std::uint64_t seed, std::string_view name, std::uint64_t count);

}  // namespace cmrc
