#include "cmrc/measures/event_times.hpp"

#include <algorithm>
#include <chrono>

#include "state/visitor.hpp"

namespace cmrc {

void EventTimes::add(Time time) {
  ++count_;
  last_ = std::max(last_, time);
  if (bin_ > Time{}) return count_in_bin(time);
  kept_.push_back(time);
  if (kept_.size() <= kept_max_) return;
  bin_ = std::chrono::milliseconds{1};
  for (const Time before : kept_) count_in_bin(before);
  kept_ = {};
}

void EventTimes::count_in_bin(Time time) {
  while (static_cast<std::size_t>(time / bin_) >= bins_max_) {
    for (std::size_t i = 0; i < bins_.size(); ++i) {
      const std::uint32_t moved = bins_[i];
      bins_[i] = 0;
      bins_[i / 2] += moved;
    }
    bins_.resize((bins_.size() + 1) / 2);
    bin_ *= 2;
  }
  const auto index = static_cast<std::size_t>(time / bin_);
  if (index >= bins_.size()) bins_.resize(index + 1);
  ++bins_[index];
}

std::uint64_t EventTimes::until(Time end) const {
  if (end >= last_) return count_;
  if (end < Time{}) return 0;
  if (bin_ == Time{})
    return static_cast<std::uint64_t>(std::ranges::count_if(kept_, [end](Time time) { return time <= end; }));
  const auto cut = static_cast<std::size_t>(end / bin_);
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < std::min(cut, bins_.size()); ++i) sum += bins_[i];
  if (cut < bins_.size())
    sum += bins_[cut] * static_cast<std::uint64_t>((end % bin_).count()) / static_cast<std::uint64_t>(bin_.count());
  return sum;
}

std::vector<EventTimes::Group> EventTimes::in_order() const {
  std::vector<Group> all;
  all.reserve(kept_.size());
  for (const Time time : kept_) all.push_back({time, 1});
  std::ranges::sort(all, {}, &Group::time);
  for (std::size_t i = 0; i < bins_.size(); ++i) {
    if (bins_[i] > 0) all.push_back({static_cast<std::int64_t>(i) * bin_, bins_[i]});
  }
  return all;
}

void EventTimes::list_state(state::Visitor& list) {
  list("count", count_);
  list("last", last_);
  list("bin", bin_);
  list("kept", kept_);
  list("bins", bins_);
}

}  // namespace cmrc
