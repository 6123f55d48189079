#include "bus_model/arbiter.hpp"

#include <bit>

namespace pci {

namespace {

// The first bit of `mask` after bit `last`, in a ring. The mask is not 0.
unsigned first_after(std::uint64_t mask, unsigned last) {
  const std::uint64_t after = mask & (~std::uint64_t{1} << last);
  return static_cast<unsigned>(std::countr_zero(after != 0 ? after : mask));
}

}  // namespace

void Arbiter::add_master(bool first_level) {
  const bool first = config_.arbitration == Arbitration::host_fair ? config_.host_bridge && masters_ == 0 : first_level;
  first_level_ |= std::uint32_t{first} << masters_;
  masters_ += 1;
}

unsigned Arbiter::pick(std::uint32_t asking, Clocks clock) const {
  if (config_.multi_transaction_timer > 0 && clock < kept_until() && (asking >> last_owner_ & 1u) != 0)
    return last_owner_;
  switch (config_.arbitration) {
    case Arbitration::round_robin: return first_after(asking, last_owner_);
    case Arbitration::fixed: return static_cast<unsigned>(std::countr_zero(asking));
    case Arbitration::two_level:
    case Arbitration::host_fair: break;
  }
  const std::uint32_t second_level = asking & ~first_level_;
  const std::uint64_t places = (asking & first_level_) | std::uint64_t{second_level != 0} << masters_;
  const unsigned place = first_after(places, last_place_);
  return place < masters_ ? place : first_after(second_level, last_of_second_);
}

}  // namespace pci
