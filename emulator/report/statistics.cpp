#include "report/statistics.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

namespace report {
namespace {

/// Nearest rank: the smallest sample with at least per_mille / 1000 of all samples at or below it.
std::int64_t percentile(const std::vector<std::int64_t>& sorted, std::uint64_t per_mille) {
  const std::uint64_t rank = (sorted.size() * per_mille + 999) / 1000;
  return sorted[std::max<std::uint64_t>(rank, 1) - 1];
}

}  // namespace

Summary Distribution::summary() const {
  Summary result;
  result.count = samples_.size();
  if (samples_.empty()) return result;
  std::vector<std::int64_t> sorted = samples_;
  std::ranges::sort(sorted);
  // Integer sums first: the mean then does not depend on the order of the samples.
  const auto sum = std::accumulate(sorted.begin(), sorted.end(), std::int64_t{0});
  result.best = sorted.front();
  result.worst = sorted.back();
  result.mean = static_cast<double>(sum) / static_cast<double>(sorted.size());
  result.p50 = percentile(sorted, 500);
  result.p99 = percentile(sorted, 990);
  result.p99_9 = percentile(sorted, 999);
  for (const std::int64_t sample : sorted)
    ++result.histogram[sample <= 0 ? 0 : static_cast<std::size_t>(std::bit_width(static_cast<std::uint64_t>(sample)))];
  return result;
}

}  // namespace report
