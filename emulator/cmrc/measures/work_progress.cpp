#include "cmrc/measures/work_progress.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace cmrc {

using report::seconds;

namespace {

/// The milestones of one robot within the window, in order; none comes before an earlier one.
std::vector<Milestone> milestones_of(const Course& course, Robot robot, Time from, Time to) {
  std::vector<Milestone> all;
  Time last = from;
  for (const Milestone& milestone : course.milestones()) {
    if (milestone.robot != robot || milestone.at > to) continue;
    all.push_back(milestone);
    all.back().at = last = std::max(last, milestone.at);
  }
  return all;
}

}  // namespace

WorkProgress::WorkProgress(const Course& run, const Course& ideal, Robot robot, Time from, Time to)
    : to_(to), itself_(&run == &ideal) {
  way_.push_back({from, 0});
  std::map<std::uint64_t, double> places;
  for (const Milestone& milestone : milestones_of(ideal, robot, from, to)) {
    const double done = static_cast<double>(places.size() + 1);
    if (places.emplace(milestone.key, done).second) way_.push_back({milestone.at, done});
  }
  knots_.push_back({from, 0});
  for (const Milestone& milestone : milestones_of(run, robot, from, to)) {
    const auto place = places.find(milestone.key);
    if (place != places.end() && place->second > knots_.back().done) knots_.push_back({milestone.at, place->second});
  }
}

Time WorkProgress::ideal_time(Time time) {
  if (itself_) return time;
  while (next_ < knots_.size() && knots_[next_].at <= time) ++next_;
  const Knot& last = knots_[next_ - 1];
  // Nothing is left to do: the run keeps the lag that it had at the end.
  if (last.done >= way_.back().done) return time - (last.at - way_.back().at);
  double done = last.done;
  if (next_ < knots_.size()) {
    const Knot& next = knots_[next_];
    done += (next.done - last.done) * seconds(time - last.at) / seconds(next.at - last.at);
  }
  const auto below = std::min(static_cast<std::size_t>(done), way_.size() - 2);
  const Time span = way_[below + 1].at - way_[below].at;
  return way_[below].at + Time{std::llround((done - static_cast<double>(below)) * static_cast<double>(span.count()))};
}

report::Lag WorkProgress::lag(std::string name) const {
  report::Lag lag{std::move(name), 0, 0};
  WorkProgress again = *this;
  again.next_ = 1;
  // Between two knots the lag has its extremes at the ends.
  const auto look = [&](Time time) {
    lag.end_s = seconds(time - again.ideal_time(time));
    lag.peak_s = std::max(lag.peak_s, lag.end_s);
  };
  for (const Knot& knot : knots_) {
    if (knot.at > knots_.front().at) look(knot.at - Time{1});
    look(knot.at);
  }
  look(to_);
  return lag;
}

}  // namespace cmrc
