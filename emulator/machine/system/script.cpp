#include "machine/system/script.hpp"

#include <algorithm>

namespace machine {

void Script::act(Time now) {
  const ScriptedEvent event = events_[done++];
  act_(event, now);
}

void Script::add(const ScriptedEvent& event) {
  const auto earlier = [](const ScriptedEvent& a, const ScriptedEvent& b) { return a.time < b.time; };
  const auto to_come = events_.begin() + static_cast<std::ptrdiff_t>(done);
  events_.insert(std::upper_bound(to_come, events_.end(), event, earlier), event);
  changed();
}

}  // namespace machine
