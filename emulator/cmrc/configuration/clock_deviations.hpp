#pragma once
// Clocks that differ (ruling 40): with run.phase_jitter each oscillator has a frequency of its own, up to 100 ppm from
// the nominal one, and a phase of its own. Without it all begin at 0 and keep their nominal frequency; so do the chips
// and buses of the ideal run, in which time costs nothing. Host timer, sensors and AGV units of the ideal run are the
// run's own.
//
// The drives' 8-kHz latch is not among them: it is the plant's mesh (ruling 5).
#include <cstdint>
#include <string>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "machine/time.hpp"

namespace cmrc {

inline constexpr std::int64_t most_ppm = 100;

/// One oscillator: its nominal clock, and how it departs from it.
struct Oscillator {
  std::string name;             ///< "host timer", "PCI A", "DSP 0", "sway sensor", "range sensor 0", "AGV unit 0"
  std::int64_t hertz, per = 1;  ///< nominal frequency hertz / per
  machine::Skew skew;
};

/// The oscillators of a run.
struct Oscillators {
  Oscillator host;
  std::vector<Oscillator> buses, dsps;  ///< by bus and slot
  Oscillator sway;
  std::vector<Oscillator> range;  ///< by AGV; none where the range sensors follow the AGVs' steps (docs/plant.md)
  std::vector<Oscillator> units;  ///< by AGV

  /// All, in this order.
  std::vector<Oscillator> all() const;
};

/// Whole ppm from -100 to 100, and a phase of whole picoseconds within one period: drawn from run.seed and the
/// oscillator's name alone, so that adding a DSP changes no other clock.
/// \throws ConfigError where a frequency that is drawn cannot be represented (machine::Clock)
Oscillators oscillators_of(const Config& config);

/// A number from 0 up to 1 by seed, name and count alone.
double unit_draw(std::uint64_t seed, std::string_view name, std::uint64_t count);

}  // namespace cmrc
