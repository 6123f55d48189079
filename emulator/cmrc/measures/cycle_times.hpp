#pragma once
// Cycles of a chip by cause, and the time that they took.
#include <cstdint>
#include <string>
#include <vector>

#include "machine/time/time.hpp"

namespace cmrc {

using CauseTimes = std::vector<std::int64_t>;  ///< cycles of one chip by cause; empty: not known

/// By cause; empty unless both are known.
CauseTimes minus(const CauseTimes& later, const CauseTimes& earlier);

/// The sum by cause; an empty list counts as zero.
std::vector<std::int64_t> plus(const std::vector<std::int64_t>& one, std::vector<std::int64_t> other);

/// Cycles to picoseconds such that the parts add up to the whole exactly: each cumulative sum is rounded down, not each
/// part.
std::vector<std::int64_t> in_picoseconds(const CauseTimes& cycles, std::int64_t whole);

/// The time of runs by a chain's causes: those of the chips, a slowed clock, and runs whose counters are not known.
class ChainTimes {
 public:
  ChainTimes(std::vector<std::string> chip_causes, machine::Clock chip_clock);

  const std::vector<std::string>& causes() const { return causes_; }
  /// A run's picoseconds by cause; they add up to the whole. \param ended before its end the clock may still change
  std::vector<std::int64_t> of(const CauseTimes& cycles, std::int64_t whole, bool ended) const;

 private:
  std::vector<std::string> causes_;
  machine::Clock chip_clock_;  // nominal
};

}  // namespace cmrc
