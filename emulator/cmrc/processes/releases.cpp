#include "cmrc/processes/releases.hpp"

#include <utility>

#include "state/visitor.hpp"

namespace cmrc {

std::int64_t congruent_before(std::int64_t tick, std::int64_t phase, std::int64_t period) {
  const std::int64_t since = (tick - phase) % period;
  return tick - (since < 0 ? since + period : since);
}

bool RangeField::entered(Word millimetres, const RangeWatch& watch) {
  const std::int64_t nearest = millimetres;
  const auto before = std::exchange(last_, nearest);
  if (nearest >= watch.field_mm) return false;
  return !before || *before >= watch.field_mm || nearest < *before - jump_mm;
}

std::vector<std::int64_t> Release::passed(std::int64_t tick, std::int64_t period, bool staggered) const {
  std::vector<std::int64_t> all;
  if (!row_->by_interval()) return all;
  const std::int64_t first = congruent_before(seen_, phase(period, staggered), period) + period;
  for (std::int64_t nominal = first; nominal + period <= tick; nominal += period) all.push_back(nominal);
  return all;
}

std::optional<Release::Last> Release::last_passed(std::int64_t tick, std::int64_t period, bool staggered,
                                                  bool out) const {
  const std::int64_t last = congruent_before(tick, phase(period, staggered), period);
  if (!row_->by_interval() || last <= seen_ || (out && deadline_ > last)) return std::nullopt;
  return Last{last, out};
}

Release::Due Release::due(std::int64_t tick, std::int64_t period, bool staggered) {
  Due due;
  due.dropped = passed(tick, period, staggered);
  const auto last = last_passed(tick, period, staggered, out_);
  seen_ = tick;
  if (last && last->dropped) due.dropped.push_back(last->nominal);
  due.load = last && !last->dropped;
  if (object_ && !out_) due.load = true;
  if (due.load) object_ = false;
  return due;
}

void Release::list_state(state::Visitor& list) {
  list("seen", seen_);
  list("deadline", deadline_);
  list("out", out_);
  list("object", object_);
  list("stopped", stopped_);
}

void RangeField::list_state(state::Visitor& list) { list("last", last_); }

}  // namespace cmrc
