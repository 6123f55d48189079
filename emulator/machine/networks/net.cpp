#include "machine/networks/net.hpp"

#include <algorithm>
#include <utility>

#include "state/visitor.hpp"

namespace machine {

using c40::Drive;

Net::Net(NetDescription description, const std::vector<PinOwner*>& owners)
    : description_{std::move(description)},
      drives_(description_.drivers.size() + 1, Drive::none),
      receivers_(description_.receivers.size(), Receiver{description_.rest, {}}),
      level_{description_.rest} {
  for (const ChipPin& pin : description_.drivers) drivers_.push_back(owners.at(pin.chip));
  for (const ChipPin& pin : description_.receivers) owners_.push_back(owners.at(pin.chip));
}

void Net::start() {
  for (std::size_t i = 0; i < receivers_.size(); ++i)
    owners_[i]->pin_changes(description_.receivers[i].pin, level_, Time{0});
}

// ---- drivers ----

void Net::add(const Change& change) {
  const auto later = std::ranges::upper_bound(changes_, change.time, {}, &Change::time);
  changes_.insert(later, change);
  changed();
}

void Net::driven(const ChipPin& pin, Drive drive, Time at) {
  const auto driver = std::ranges::find(description_.drivers, pin) - description_.drivers.begin();
  add({at, static_cast<std::size_t>(driver), drive});
}

void Net::script(Drive drive, Time at) {
  pulsing_ = false;
  add({at, script(), drive});
}

void Net::script(const PulseTrain& pulses) {
  pulses_ = pulses;
  pulse_ = 0;
  pulsing_ = true;
  changed();
}

std::optional<Net::Change> Net::next_pulse() const {
  if (!pulsing_) return {};
  const Time begins = pulses_.first + pulses_.period * static_cast<std::int64_t>(pulse_ / 2);
  const bool ends = pulse_ % 2 == 1;
  return Change{ends ? begins + pulses_.width : begins, script(),
                ends ? Drive::none : c40::drive_to(!description_.rest)};
}

bool Net::resulting_level() const {
  bool high = false, low = false;
  for (const Drive drive : drives_) high |= drive == Drive::high, low |= drive == Drive::low;
  return low ? false : high || description_.rest;
}

// ---- effects ----

Time Net::next() const {
  Time next = changes_.empty() ? never : changes_.front().time;
  if (const auto pulse = next_pulse()) next = std::min(next, pulse->time);
  for (const Receiver& receiver : receivers_)
    if (!receiver.seen.empty()) next = std::min(next, receiver.seen.front().due);
  return next;
}

void Net::act(Time now) {
  for (auto pulse = next_pulse(); pulse && pulse->time <= now; pulse = next_pulse()) {
    ++pulse_;
    if (pulses_.count != 0 && pulse_ == 2 * pulses_.count) pulsing_ = false;
    drives_[pulse->source] = pulse->drive;
  }
  // A driver that changes back at the same instant makes two edges, whether or not the first has acted already.
  for (std::size_t last = drives_.size(); !changes_.empty() && changes_.front().time <= now; changes_.pop_front()) {
    if (changes_.front().source == last) settle(now);
    last = changes_.front().source;
    drives_[last] = changes_.front().drive;
  }
  settle(now);
  for (std::size_t i = 0; i < receivers_.size(); ++i) {
    Receiver& receiver = receivers_[i];
    while (!receiver.seen.empty() && receiver.seen.front().due <= now) {
      const bool level = receiver.seen.front().level;
      receiver.seen.pop_front();
      if (level == std::exchange(receiver.level, level)) continue;
      owners_[i]->pin_changes(description_.receivers[i].pin, level, now);
    }
  }
}

// All drivers of one instant together make one level.
void Net::settle(Time now) {
  const bool level = resulting_level();
  if (level == level_) return;
  level_ = level;
  ++edges_;
  if (listener != nullptr) listener->changed(*this, level, now);
  for (std::size_t i = 0; i < receivers_.size(); ++i) {
    Receiver& receiver = receivers_[i];
    const Time at = due(i, now);
    if (receiver.seen.empty() || receiver.seen.back().due != at) {
      receiver.seen.push_back({at, level});
      continue;
    }
    // The level changed and changed back between two looks.
    receiver.seen.pop_back();
    ++missed_;
    if (listener != nullptr) listener->missed(*this, description_.receivers[i].chip, now);
  }
}

/// When an edge reaches a receiver's pin, after the synchroniser.
Time Net::due(std::size_t receiver, Time edge) const {
  const PinOwner& owner = *owners_[receiver];
  return owner.time_of(owner.cycle_from(edge) + 1);
}

Time Net::reaches(std::size_t chip) const {
  Time edge = changes_.empty() ? never : changes_.front().time;
  if (const auto pulse = next_pulse()) edge = std::min(edge, pulse->time);
  for (const PinOwner* driver : drivers_) edge = std::min(edge, driver->drives_from());
  for (const PinOwner* mover : movers_) edge = std::min(edge, mover->drives_from());
  Time reach = never;
  for (std::size_t i = 0; i < receivers_.size(); ++i) {
    if (description_.receivers[i].chip != chip) continue;
    if (!receivers_[i].seen.empty()) reach = std::min(reach, receivers_[i].seen.front().due);
    if (edge != never) reach = std::min(reach, due(i, edge));
  }
  return reach;
}

bool Net::has_listener() const {
  for (std::size_t i = 0; i < owners_.size(); ++i)
    if (owners_[i]->listens_to(description_.receivers[i].pin)) return true;
  return false;
}

bool Net::is_low_at(const ChipPin& pin) const {
  const auto receiver = std::ranges::find(description_.receivers, pin) - description_.receivers.begin();
  return receiver != std::ssize(receivers_) && !receivers_[static_cast<std::size_t>(receiver)].level;
}

void Net::Receiver::list_state(state::Visitor& list) {
  list("level", level);
  list("seen", seen);
}

void Net::list_state(state::Visitor& list) {
  list("drives", drives_);
  list("changes", changes_);
  list("receivers", receivers_);
  list("pulses", pulses_);
  list("pulse", pulse_);
  list("pulsing", pulsing_);
  list("level", level_);
  list("edges", edges_);
  list("missed", missed_);
}

}  // namespace machine
