#include "bus_model/statistics.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace pci {

std::size_t Histogram::bin(Clocks value) {
  const auto v = static_cast<std::uint64_t>(value < 0 ? 0 : value);
  if (v < exact) return static_cast<std::size_t>(v);
  const auto octave = static_cast<unsigned>(std::bit_width(v)) - 1;
  if (octave >= 32) return bins - 1;
  return exact + ((octave - bits - 1) << bits) + ((v >> (octave - bits)) & ((1U << bits) - 1));
}

void Histogram::add_other(Clocks value) {
  const std::size_t index = bin(value);
  if (index >= counts_.size()) counts_.resize(index + 1);
  counts_[index] += 1;
  others_sum_ += value;
  others_max_ = std::max(others_max_, value);
  others_min_ = std::min(others_min_, value);
}

std::uint64_t Histogram::count() const { return std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0}); }

Clocks Histogram::sum() const {
  Clocks sum = others_sum_;
  for (std::size_t bin = 0; bin < exact; ++bin) sum += static_cast<Clocks>(bin * counts_[bin]);
  return sum;
}

Clocks Histogram::max() const {
  if (others_max_ > 0) return others_max_;
  std::size_t last = exact;
  while (last > 0 && counts_[last - 1] == 0) --last;
  return last == 0 ? 0 : static_cast<Clocks>(last - 1);
}

Clocks Histogram::min() const {
  const auto first = std::find_if(counts_.begin(), counts_.begin() + exact, [](std::uint64_t n) { return n != 0; });
  if (others_min_ < 0 || first == counts_.begin() + exact) return count() == 0 ? 0 : others_min_;
  return first - counts_.begin();
}

Clocks Histogram::upper_edge(std::size_t bin) {
  if (bin < exact) return static_cast<Clocks>(bin);
  constexpr std::size_t parts = std::size_t{1} << bits;
  const std::size_t octave = bits + 1 + (bin - exact) / parts;
  const std::size_t part = (bin - exact) % parts;
  return (static_cast<Clocks>(parts + part + 1) << (octave - bits)) - 1;
}

Clocks Histogram::percentile(double fraction) const {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(fraction * static_cast<double>(count())));
  std::uint64_t seen = 0;
  for (std::size_t bin = 0; bin < counts_.size(); ++bin) {
    seen += counts_[bin];
    if (seen >= wanted && seen > 0) return std::min(upper_edge(bin), max());
  }
  return max();
}

std::array<std::uint64_t, 32> Histogram::octaves() const {
  std::array<std::uint64_t, 32> result{};
  for (std::size_t bin = 0; bin < counts_.size(); ++bin) {
    const auto value = static_cast<std::uint64_t>(upper_edge(bin));
    const std::size_t octave = value == 0 ? 0 : static_cast<std::size_t>(std::bit_width(value)) - 1;
    result[std::min<std::size_t>(octave, 31)] += counts_[bin];
  }
  return result;
}

void Histogram::list_state(state::Visitor& list) {
  list("counts", counts_);
  list("sum of others", others_sum_);
  list("max of others", others_max_);
  list("min of others", others_min_);
}

}  // namespace pci
