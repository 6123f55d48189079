#pragma once
// Statistics of integer samples (picoseconds, bus clocks) in bounded memory.
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace state {
class Visitor;
}

namespace report {

/// An amount with its name, in a fixed order: cycles or picoseconds by cause.
struct Share {
  std::string name;
  std::int64_t amount = 0;
};

/// Bin k counts samples in [2^(k-1), 2^k); bin 0 counts samples <= 0.
using Log2Histogram = std::array<std::uint64_t, 64>;

/// The summary of a set of samples. All zero without samples.
struct Summary {
  std::uint64_t count = 0;
  std::int64_t best = 0;
  double mean = 0;
  std::int64_t p50 = 0;  ///< smallest sample that is not below 50 % of the samples (nearest rank)
  std::int64_t p99 = 0;
  std::int64_t p99_9 = 0;
  std::int64_t worst = 0;
  Log2Histogram histogram{};
  bool exact_percentiles = true;  ///< otherwise within 0.1 % of a sample of that rank
};

__extension__ using WideInteger = __int128;

/// Collects samples. Count, best, worst, mean and histogram are exact. Percentiles are exact up to `samples_max`
/// samples; beyond, samples are counted in bins, each no wider than 1/1024 of its values.
class Distribution {
 public:
  static constexpr std::size_t usual_samples_max = 65'536;

  explicit Distribution(std::size_t samples_max = usual_samples_max) : samples_max_(samples_max) {}

  void add(std::int64_t sample);
  std::uint64_t count() const { return counted_.count; }
  Summary summary() const;
  void list_state(state::Visitor& list);

 private:
  std::int64_t percentile_of_bins(std::uint64_t per_mille) const;

  std::size_t samples_max_;
  Summary counted_;                    // everything except the mean and the percentiles
  WideInteger sum_ = 0;                // an integer, so that the mean does not depend on the order of the samples
  std::vector<std::int64_t> samples_;  // while there are few
  std::map<std::int64_t, std::uint64_t> bins_;  // later: number of samples, by the bin's value nearest to zero
};

/// Deviation of the starts of a periodic task from its period: start[i+1] - start[i] - period, between neighbouring
/// ticks only.
struct Jitter {
  std::uint64_t count = 0;
  std::int64_t peak_to_peak = 0;  ///< largest minus smallest deviation
  std::int64_t worst = 0;         ///< largest absolute deviation
  double rms = 0;
};

/// Collects the starts of a periodic task.
class Starts {
 public:
  /// \param period ps; 0: the task is not periodic and has no jitter
  explicit Starts(std::int64_t period) : period_(period) {}

  /// The start of the tick with that number, ps. Each tick has one; starts may come out of order by less than
  /// `remembered` ticks.
  void add(std::int64_t tick, std::int64_t time);
  Jitter jitter() const;
  void list_state(state::Visitor& list);

  static constexpr std::size_t remembered = 64;

 private:
  void deviates(std::int64_t deviation);

  std::int64_t period_;
  std::map<std::int64_t, std::int64_t> newest_;  // times by tick
  std::uint64_t count_ = 0;
  std::int64_t smallest_ = 0, largest_ = 0;
  WideInteger squares_ = 0;
};

}  // namespace report
