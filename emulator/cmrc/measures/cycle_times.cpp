#include "cmrc/measures/cycle_times.hpp"

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <utility>

namespace cmrc {
namespace {

/// whole * part / total, rounded down for positive numbers.
std::int64_t share(std::int64_t whole, std::int64_t part, std::int64_t total) {
  __extension__ using Wide = __int128;
  if (std::int64_t product = 0; !__builtin_mul_overflow(whole, part, &product)) return product / total;
  return static_cast<std::int64_t>(Wide{whole} * part / total);
}

std::int64_t sum_of(const std::vector<std::int64_t>& parts) {
  return std::accumulate(parts.begin(), parts.end(), std::int64_t{0});
}

/// As in_picoseconds(), with the nominal length of cycles, and the additional time of a slowed clock. (One picosecond
/// is the clock's rounding.)
std::vector<std::int64_t> with_clock(const CauseTimes& cycles, std::int64_t whole, const machine::Clock& clock) {
  const std::int64_t total = sum_of(cycles);
  std::int64_t nominal = clock.at(total).count();
  if (std::abs(whole - nominal) <= 1) nominal = whole;
  std::vector<std::int64_t> parts = in_picoseconds(cycles, nominal);
  const std::int64_t known = sum_of(parts);
  parts.push_back(whole - nominal);
  parts.push_back(nominal - known);
  return parts;
}

}  // namespace

CauseTimes minus(const CauseTimes& later, const CauseTimes& earlier) {
  if (later.size() != earlier.size()) return {};
  CauseTimes difference(later.size());
  std::ranges::transform(later, earlier, difference.begin(), std::minus{});
  return difference;
}

std::vector<std::int64_t> plus(const std::vector<std::int64_t>& one, std::vector<std::int64_t> other) {
  if (one.empty()) return other;
  std::vector<std::int64_t> sum = one;
  for (std::size_t i = 0; i < sum.size() && i < other.size(); ++i) sum[i] += other[i];
  return sum;
}

std::vector<std::int64_t> in_picoseconds(const CauseTimes& cycles, std::int64_t whole) {
  const std::int64_t total = sum_of(cycles);
  std::vector<std::int64_t> parts;
  parts.reserve(cycles.size() + 2);  // with_clock adds two
  std::int64_t sum = 0, before = 0;
  for (const std::int64_t count : cycles) {
    sum += count;
    std::int64_t until = before;  // most causes took no cycle
    if (count != 0) until = total == 0 ? 0 : share(whole, sum, total);
    parts.push_back(until - before);
    before = until;
  }
  return parts;
}

ChainTimes::ChainTimes(std::vector<std::string> chip_causes, machine::Clock chip_clock)
    : causes_(std::move(chip_causes)), chip_clock_(chip_clock) {
  causes_.insert(causes_.end(), {"slow_clock", "unknown"});
}

std::vector<std::int64_t> ChainTimes::of(const CauseTimes& cycles, std::int64_t whole, bool ended) const {
  std::vector<std::int64_t> times;
  if (!cycles.empty()) times = ended ? with_clock(cycles, whole, chip_clock_) : in_picoseconds(cycles, whole);
  times.resize(causes_.size(), 0);
  times.back() += whole - sum_of(times);
  return times;
}

}  // namespace cmrc
