#include "cmrc/host/liveness.hpp"

#include <algorithm>

#include "state/visitor.hpp"

namespace cmrc {

Liveness::Slot& Liveness::known(unsigned slot) {
  known_ = std::max<std::size_t>(known_, slot + 1);
  return slots_.at(slot);
}

void Liveness::sign(unsigned slot, std::int64_t refresh) { known(slot) = {State::alive, refresh}; }

void Liveness::signs(std::uint32_t mask, std::int64_t refresh) {
  for (unsigned slot = 0; slot < slots_.size(); ++slot) {
    if ((mask >> slot & 1) != 0) sign(slot, refresh);
  }
}

void Liveness::renewed(unsigned slot, std::int64_t refresh) { known(slot) = {State::reset, refresh}; }

bool Liveness::doubtful(std::int64_t refresh, std::int64_t limit) const {
  return std::any_of(slots_.begin(), slots_.begin() + static_cast<std::ptrdiff_t>(known_),
                     [&](const Slot& slot) { return slot.state != State::unknown && refresh - slot.last > limit; });
}

std::vector<Liveness::Finding> Liveness::judge(std::int64_t refresh, std::int64_t limit) {
  std::vector<Finding> all;
  for (unsigned number = 0; number < slots_.size(); ++number) {
    Slot& slot = slots_[number];
    if (slot.state == State::unknown || refresh - slot.last <= limit) continue;
    all.push_back({number, slot.state == State::alive ? Verdict::silent : Verdict::dead});
    slot = {slot.state == State::alive ? State::reset : State::unknown, refresh};
  }
  return all;
}

void Liveness::list_state(state::Visitor& list) {
  list("slots", slots_);
  if (!list.loads()) return;
  known_ = slots_.size();
  while (known_ > 0 && slots_[known_ - 1].state == State::unknown) --known_;
}

}  // namespace cmrc
