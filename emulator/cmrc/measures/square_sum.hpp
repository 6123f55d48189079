#pragma once
// From samples of a quantity: their RMS and peak.
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace cmrc {

struct SquareSum {
  double squares = 0, peak = 0;
  std::uint64_t count = 0;

  void add(double sample) {
    squares += sample * sample;
    peak = std::max(peak, std::abs(sample));
    ++count;
  }
};

}  // namespace cmrc
