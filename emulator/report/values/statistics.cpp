#include "report/values/statistics.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <iterator>

#include "state/visitor.hpp"

namespace report {
namespace {

constexpr int bin_bits = 10;  // bits of a value that select its bin

/// The place in a sorted row, counted from 1, of the smallest sample that has at least per_mille / 1000 of all samples
/// at or below it.
std::uint64_t rank(std::uint64_t count, std::uint64_t per_mille) {
  return std::max<std::uint64_t>((count * per_mille + 999) / 1000, 1);
}

std::uint64_t magnitude(std::int64_t value) {
  return value < 0 ? 0 - static_cast<std::uint64_t>(value) : static_cast<std::uint64_t>(value);
}

/// Number of bits below those that select a value's bin.
int bits_below(std::int64_t value) {
  return std::max(0, static_cast<int>(std::bit_width(magnitude(value))) - 1 - bin_bits);
}

/// The value of the same bin nearest to zero.
std::int64_t bin_of(std::int64_t value) {
  const auto kept = static_cast<std::int64_t>(magnitude(value) >> bits_below(value) << bits_below(value));
  return value < 0 ? -kept : kept;
}

/// Samples by rank. Counts them once in groups of equal width, so that only the group of a rank needs an order.
class Ranked {
 public:
  Ranked(const std::vector<std::int64_t>& samples, const Summary& range)
      : samples_(samples),
        best_(range.best),
        shift_(std::max(0, static_cast<int>(std::bit_width(above_best(range.worst))) - bin_bits)) {
    for (const std::int64_t sample : samples_) ++counts_[group(sample)];
  }

  /// \param rank counted from 1
  std::int64_t at(std::uint64_t rank) const {
    std::size_t here = 0;
    while (rank > counts_[here]) rank -= counts_[here++];
    std::vector<std::int64_t> chosen;
    chosen.reserve(counts_[here]);
    std::ranges::copy_if(samples_, std::back_inserter(chosen), [&](std::int64_t some) { return group(some) == here; });
    const auto at = chosen.begin() + static_cast<std::ptrdiff_t>(rank - 1);
    std::ranges::nth_element(chosen, at);
    return *at;
  }

 private:
  std::uint64_t above_best(std::int64_t sample) const {
    return static_cast<std::uint64_t>(sample) - static_cast<std::uint64_t>(best_);
  }
  std::size_t group(std::int64_t sample) const { return static_cast<std::size_t>(above_best(sample) >> shift_); }

  const std::vector<std::int64_t>& samples_;
  std::int64_t best_;
  int shift_;
  std::array<std::uint64_t, std::size_t{1} << bin_bits> counts_{};
};

}  // namespace

void Distribution::add(std::int64_t sample) {
  counted_.best = counted_.count == 0 ? sample : std::min(counted_.best, sample);
  counted_.worst = counted_.count == 0 ? sample : std::max(counted_.worst, sample);
  ++counted_.count;
  ++counted_.histogram[sample <= 0 ? 0 : static_cast<std::size_t>(std::bit_width(static_cast<std::uint64_t>(sample)))];
  sum_ += sample;
  if (counted_.count <= samples_max_) {
    samples_.push_back(sample);
    return;
  }
  for (const std::int64_t before : samples_) ++bins_[bin_of(before)];
  samples_ = {};
  ++bins_[bin_of(sample)];
}

// The middle of the bin that holds the sample of that rank.
std::int64_t Distribution::percentile_of_bins(std::uint64_t per_mille) const {
  std::uint64_t left = rank(counted_.count, per_mille);
  for (const auto& [bin, count] : bins_) {
    if (count < left) {
      left -= count;
      continue;
    }
    const std::int64_t half = (std::int64_t{1} << bits_below(bin)) / 2;
    return std::clamp(bin < 0 ? bin - half : bin + half, counted_.best, counted_.worst);
  }
  return counted_.worst;
}

Summary Distribution::summary() const {
  Summary result = counted_;
  if (result.count == 0) return result;
  result.mean = static_cast<double>(sum_) / static_cast<double>(result.count);
  result.exact_percentiles = bins_.empty();
  if (!result.exact_percentiles) {
    result.p50 = percentile_of_bins(500);
    result.p99 = percentile_of_bins(990);
    result.p99_9 = percentile_of_bins(999);
    return result;
  }
  const Ranked sorted(samples_, counted_);
  result.p50 = sorted.at(rank(result.count, 500));
  result.p99 = sorted.at(rank(result.count, 990));
  result.p99_9 = sorted.at(rank(result.count, 999));
  return result;
}

void Distribution::list_state(state::Visitor& list) {
  list("counted", counted_);
  list("sum", sum_);
  list("samples", samples_);
  list("bins", bins_);
}

void Starts::list_state(state::Visitor& list) {
  list("newest", newest_);
  list("count", count_);
  list("smallest", smallest_);
  list("largest", largest_);
  list("squares", squares_);
}

void Starts::deviates(std::int64_t deviation) {
  smallest_ = count_ == 0 ? deviation : std::min(smallest_, deviation);
  largest_ = count_ == 0 ? deviation : std::max(largest_, deviation);
  squares_ += WideInteger{deviation} * deviation;
  ++count_;
}

void Starts::add(std::int64_t tick, std::int64_t time) {
  if (period_ == 0) return;
  const auto [here, added] = newest_.emplace(tick, time);
  if (!added) return;
  if (here != newest_.begin() && std::prev(here)->first == tick - 1) deviates(time - std::prev(here)->second - period_);
  if (const auto next = std::next(here); next != newest_.end() && next->first == tick + 1)
    deviates(next->second - time - period_);
  if (newest_.size() > remembered) newest_.erase(newest_.begin());
}

Jitter Starts::jitter() const {
  if (count_ == 0) return {};
  return {count_, largest_ - smallest_, std::max(std::abs(smallest_), std::abs(largest_)),
          std::sqrt(static_cast<double>(squares_) / static_cast<double>(count_))};
}

}  // namespace report
