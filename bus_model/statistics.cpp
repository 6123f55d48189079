#include "bus_model/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace pci {

Clocks Histogram::upper_edge(std::size_t bin) {
  if (bin < exact) return static_cast<Clocks>(bin);
  constexpr std::size_t parts = std::size_t{1} << bits;
  const std::size_t octave = bits + 1 + (bin - exact) / parts;
  const std::size_t part = (bin - exact) % parts;
  return (static_cast<Clocks>(parts + part + 1) << (octave - bits)) - 1;
}

Clocks Histogram::percentile(double fraction) const {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(fraction * static_cast<double>(count_)));
  std::uint64_t seen = 0;
  for (std::size_t bin = 0; bin < counts_.size(); ++bin) {
    seen += counts_[bin];
    if (seen >= wanted && seen > 0) return std::min(upper_edge(bin), max_);
  }
  return max_;
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
  list("count", count_);
  list("sum", sum_);
  list("max", max_);
  list("min", min_);
}

}  // namespace pci
