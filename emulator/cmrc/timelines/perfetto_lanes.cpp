#include "cmrc/timelines/perfetto_lanes.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace cmrc {

PerfettoLanes::PerfettoLanes(Trace& trace, std::string name, Trace::Track parent, std::string_view description)
    : trace_(trace), name_(std::move(name)), parent_(parent), tracks_{trace_.add_slices(name_, parent, description)} {}

void PerfettoLanes::slice(report::Time from, report::Time to, std::string_view name, Trace::Notes notes,
                          const Inner* inner) {
  auto free = std::ranges::find_if(tracks_, [&](Trace::Track track) { return trace_.free_at(track, from); });
  if (free == tracks_.end()) {
    tracks_.push_back(trace_.add_slices(fmt::format("{} ({})", name_, tracks_.size() + 1), parent_));
    free = std::prev(tracks_.end());
  }
  trace_.begin(*free, from, name, notes);
  if (inner != nullptr) {
    trace_.begin(*free, inner->from, inner->name);
    trace_.end(*free, to);
  }
  trace_.end(*free, to);
}

}  // namespace cmrc
