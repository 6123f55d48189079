#include "cmrc/measures/work_progress.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace cmrc {

using report::seconds;

namespace {

// m. The ideal run is farther along than a run if it has got farther by more than this: more than two cranes differ
// that rest and damp a swing, and less than a crane moves in some hundredths of a second.
constexpr double farther = 0.01;

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

WorkProgress::WorkProgress(const Course& run, const Course& ideal, Robot robot, Time from, Time to,
                           const Levers& levers)
    : run_(&run), ideal_(&ideal), robot_(robot), levers_(levers), to_(to), step_(std::max(run.step(), ideal.step())) {
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
  at_ = beginning();
}

Time WorkProgress::ideal_time(Time time) {
  if (run_ == ideal_) return time;
  while (at_.next < knots_.size() && knots_[at_.next].at <= time) ++at_.next;
  if (at_.next == knots_.size()) return beyond(time);
  const Knot &last = knots_[at_.next - 1], &next = knots_[at_.next];
  const double done = last.done + (next.done - last.done) * seconds(time - last.at) / seconds(next.at - last.at);
  const auto below = std::min(static_cast<std::size_t>(done), way_.size() - 2);
  const Time span = way_[below + 1].at - way_[below].at;
  return way_[below].at + Time{std::llround((done - static_cast<double>(below)) * static_cast<double>(span.count()))};
}

// When the run passes its next milestone is not known: it lies beyond the window. A run that does after its last one
// what the ideal run did after that milestone keeps the lag that it had there; it has not passed the ideal run's next
// one. A run that stands while the ideal run moves falls behind.
Time WorkProgress::beyond(Time time) {
  const Time since = knots_.back().at, there = way_[passed()].at;
  Time same = there + (time - since);
  if (passed() + 1 < way_.size()) same = std::min(same, way_[passed() + 1].at);
  if (run_->size() == 0 || ideal_->size() == 0) return same;
  for (; at_.run_until <= time; at_.run_until += step_)
    at_.reach = std::max(at_.reach, distance(*run_, since, at_.run_until));
  while (at_.ideal_until <= same && distance(*ideal_, there, at_.ideal_until) <= at_.reach + farther)
    at_.ideal_until += step_;
  return std::min(same, at_.ideal_until);
}

double WorkProgress::distance(const Course& course, Time from, Time to) const {
  const auto before = course.at(from), after = course.at(to);
  double sum = 0;
  const auto add = [&](std::size_t column, double lever) {
    const double way = lever * (after[column] - before[column]);
    sum += way * way;
  };
  if (robot_ == 0)
    for (std::size_t j = 0; j < levers_.size(); ++j) add(j, levers_[j]);
  else
    for (std::size_t i = 0; i < 2; ++i) add(agv_column + 2 * (robot_ - 1) + i, 1);
  return std::sqrt(sum);
}

report::Lag WorkProgress::lag(std::string name) const {
  report::Lag lag{std::move(name), 0, 0};
  WorkProgress again = *this;
  again.at_ = beginning();
  // Between two knots the lag has its extremes at the ends; beyond the last one it may at any row.
  const auto look = [&](Time time) {
    lag.end_s = seconds(time - again.ideal_time(time));
    lag.peak_s = std::max(lag.peak_s, lag.end_s);
  };
  for (const Knot& knot : knots_) {
    if (knot.at > knots_.front().at) look(knot.at - Time{1});
    look(knot.at);
  }
  for (Time time = knots_.back().at; time < to_; time += step_) look(time);
  look(to_);
  return lag;
}

}  // namespace cmrc
