#include "bus_model/arbiter.hpp"

namespace pci {

void Arbiter::add_master(bool first_level) { first_level_.push_back(first_level); }

unsigned Arbiter::pick(std::span<const Clocks> requests, Clocks latest) const {
  const auto asks = [&](unsigned master) { return requests[master] <= latest; };
  const auto count = static_cast<unsigned>(requests.size());
  if (config_.multi_transaction_timer > 0 && latest < kept_until() && last_owner_ < count && asks(last_owner_))
    return last_owner_;
  if (config_.arbitration == Arbitration::two_level || config_.arbitration == Arbitration::host_fair)
    return pick_of_two_levels(requests, latest);
  const unsigned from = config_.arbitration == Arbitration::round_robin ? last_owner_ + 1 : 0;
  for (unsigned i = 0; i < count; ++i) {
    unsigned candidate = from + i;
    if (candidate >= count) candidate -= count;
    if (asks(candidate)) return candidate;
  }
  return nobody;
}

unsigned Arbiter::pick_of_two_levels(std::span<const Clocks> requests, Clocks latest) const {
  const auto count = static_cast<unsigned>(requests.size());
  const auto next_of_second = [&] {
    for (unsigned i = 1; i <= count; ++i) {
      const unsigned candidate = (last_of_second_ + i) % count;
      if (!on_first_level(candidate) && requests[candidate] <= latest) return candidate;
    }
    return nobody;
  };
  for (unsigned i = 1; i <= count + 1; ++i) {
    const unsigned place = (last_place_ + i) % (count + 1);
    if (place < count) {
      if (on_first_level(place) && requests[place] <= latest) return place;
    } else if (const unsigned candidate = next_of_second(); candidate != nobody) {
      return candidate;
    }
  }
  return nobody;
}

}  // namespace pci
