#pragma once
// Exact statistics of integer samples (picoseconds, bus clocks): nothing is binned before a percentile is taken.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace report {

/// An amount with its name, in a fixed order: cycles or picoseconds by cause.
struct Share {
  std::string name;
  std::int64_t amount = 0;
};

/// Bin k counts samples in [2^(k-1), 2^k); bin 0 counts samples <= 0.
using Log2Histogram = std::array<std::uint64_t, 64>;

/// What a report says of a set of samples. All zero when there are none.
struct Summary {
  std::uint64_t count = 0;
  std::int64_t best = 0;
  double mean = 0;
  std::int64_t p50 = 0;  ///< smallest sample that at least 50 % of the samples do not exceed (nearest rank)
  std::int64_t p99 = 0;
  std::int64_t p99_9 = 0;
  std::int64_t worst = 0;
  Log2Histogram histogram{};
};

/// Collects samples.
class Distribution {
 public:
  void add(std::int64_t sample) { samples_.push_back(sample); }
  std::uint64_t count() const { return samples_.size(); }
  Summary summary() const;

 private:
  std::vector<std::int64_t> samples_;
};

/// Deviation of the starts of a periodic task from the period: start[i+1] - start[i] - period, over neighbouring ticks
/// only.
struct Jitter {
  std::uint64_t count = 0;
  std::int64_t peak_to_peak = 0;  ///< largest minus smallest deviation
  std::int64_t worst = 0;         ///< largest absolute deviation
  double rms = 0;
};

}  // namespace report
