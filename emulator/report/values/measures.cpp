#include "report/values/measures.hpp"

#include <algorithm>

namespace report {

std::optional<double> Demand::missed() const {
  const std::uint64_t all = demanded + extra;
  return all == 0 ? std::nullopt : std::optional(static_cast<double>(misses + not_demanded) / static_cast<double>(all));
}

const Rate* Errors::rate(const std::string& name) const {
  const auto found = std::ranges::find(rates, name, &Rate::name);
  return found == rates.end() ? nullptr : &*found;
}

}  // namespace report
