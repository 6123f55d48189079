#include "cmrc/timelines/perfetto_lanes.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace cmrc {

PerfettoLanes::PerfettoLanes(Trace& trace, std::string name, Trace::Track parent, std::string_view description)
    : trace_(trace), name_(std::move(name)), parent_(parent), lanes_{{trace_.add_slices(name_, parent, description)}} {}

void PerfettoLanes::slice(report::Time from, report::Time to, std::string_view name, Trace::Notes notes,
                          const Inner* inner) {
  auto free = std::ranges::find_if(lanes_, [&](const Lane& lane) { return lane.until <= from; });
  if (free == lanes_.end()) {
    lanes_.push_back({trace_.add_slices(fmt::format("{} ({})", name_, lanes_.size() + 1), parent_)});
    free = std::prev(lanes_.end());
  }
  const Trace::Track track = free->track;
  trace_.begin(track, from, name, notes);
  if (inner != nullptr) {
    trace_.begin(track, inner->from, inner->name);
    trace_.end(track, to);
  }
  trace_.end(track, to);
  free->until = to;
}

}  // namespace cmrc
