#include "cmrc/measures.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "cmrc/ledger.hpp"

namespace cmrc {
namespace {

constexpr double residual_seconds = 12;  // after an arrival, in which the load's swing is looked at

double seconds(Time time) { return static_cast<double>(time.count()) * 1e-12; }

/// Mean square, peak and last value of something sampled.
class Sampled {
 public:
  void add(double value) {
    squares_ += value * value;
    peak_ = std::max(peak_, std::abs(value));
    end_ = value;
    ++count_;
  }
  report::Deviation told() const { return {count_ == 0 ? 0 : std::sqrt(squares_ / static_cast<double>(count_)), peak_, end_}; }
  double squares() const { return squares_; }

 private:
  double squares_ = 0, peak_ = 0, end_ = 0;
  std::size_t count_ = 0;
};

using Row = std::span<const double>;

double distance(Row a, Row b, std::size_t column, std::size_t count) {
  double sum = 0;
  for (std::size_t i = column; i < column + count; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

// ---- progress --------------------------------------------------------------------------------------------------------------

/// A robot's progress in time: at `at`, `done` milestones of the ideal run are behind it. Linear in between.
struct Knot {
  Time at;
  double done;
};

/// The milestones of one robot within the window, in order, each not before the one before it.
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

/// Where a run's robot stood on the ideal run's way, and when the ideal run stood there.
class Progress {
 public:
  Progress(const Course& run, const Course& ideal, Robot robot, Time from, Time to) : to_(to), itself_(&run == &ideal) {
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

  /// The robot does something in the ideal run.
  bool any() const { return way_.size() > 1; }

  /// The instant at which the ideal run had come as far as the run at `time`. Calls come in nondecreasing time.
  Time ideal_time(Time time) {
    if (itself_) return time;
    while (next_ < knots_.size() && knots_[next_].at <= time) ++next_;
    const Knot& last = knots_[next_ - 1];
    // Nothing is left to do: what the run was late by at the end, it stays late by.
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

  report::Lag lag(std::string name) const {
    report::Lag lag{std::move(name), 0, 0};
    Progress again = *this;
    again.next_ = 1;
    // Between two knots the lag has its extremes at their ends.
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

 private:
  Time to_;
  bool itself_;  // the ideal run beside itself: no rounding
  std::vector<Knot> way_;    // the ideal run's
  std::vector<Knot> knots_;  // the run's
  std::size_t next_ = 1;
};

// ---- demand and rates --------------------------------------------------------------------------------------------------------

struct Interval {
  Time from, to;
};

/// When planning was demanded for a robot: its legs.
std::vector<Interval> legs(const Course& course, Robot robot, Time end) {
  std::vector<Interval> all;
  bool open = false;
  for (const Milestone& milestone : course.milestones()) {
    if (milestone.robot != robot) continue;
    if (milestone.kind() == Milestone::Kind::leg_begun) {
      if (open) all.back().to = milestone.at;
      all.push_back({milestone.at, end});
      open = true;
    } else if (milestone.kind() == Milestone::Kind::leg_ended && open) {
      all.back().to = milestone.at;
      open = false;
    }
  }
  return all;
}

std::vector<Interval> servoing(const Course& course, Time end) {
  std::vector<Interval> all;
  for (std::size_t i = 0; i < course.servo_times().size(); ++i) {
    if (i % 2 == 0) all.push_back({course.servo_times()[i], end});
    else all.back().to = course.servo_times()[i];
  }
  return all;
}

/// Time in which something is demanded, without the gaps between: how much of it has passed at `time`.
Time demanded_until(const std::vector<Interval>& when, Time time) {
  Time sum{};
  for (const Interval& interval : when)
    if (time > interval.from) sum += std::min(time, interval.to) - interval.from;
  return sum;
}

/// Fewest finishes in any window of one second of the time in which they are demanded, per second; a shorter time is one window.
/// \param finished in demanded time, sorted
double worst_rate(const std::vector<Time>& finished, Time whole) {
  constexpr Time window = std::chrono::seconds{1};
  const auto count = [&](Time from, Time to) {  // in ]from, to]
    return static_cast<double>(std::ranges::upper_bound(finished, to) - std::ranges::upper_bound(finished, from));
  };
  if (whole <= window) return count(Time{-1}, whole) / seconds(whole);
  double worst = std::min(count(Time{-1}, window), count(whole - window, whole));
  for (const Time from : finished) {
    if (from + window > whole) break;
    worst = std::min(worst, count(from, from + window));
  }
  return worst;
}

/// What f_p, f_t and f_a are the rates of.
struct RateKinds {
  const char* name;
  JobKind first, second;
  double nominal_hz;
};

std::vector<RateKinds> rates_of(const Config& config) {
  const Intervals n = intervals(config);
  const double f_s = config.rates.refresh_frequency_hz;
  return {{"f_p", JobKind::torque_compensation, JobKind::pid, f_s / static_cast<double>(n.servo)},
          {"f_t", JobKind::trajectory_crane, JobKind::inverse_crane, f_s / static_cast<double>(n.crane_slowed)},
          {"f_a", JobKind::trajectory_agv, JobKind::inverse_agv, f_s / static_cast<double>(n.agv_slowed)}};
}

std::uint64_t until(const std::vector<Time>& times, Time end) {
  return static_cast<std::uint64_t>(std::ranges::count_if(times, [end](Time time) { return time <= end; }));
}

class DemandOf {
 public:
  DemandOf(const Measured& run, const Course& ideal, const JobsByRobot& demanded) : run_(run), ideal_(ideal), demanded_(demanded) {}

  report::Demand kind(std::size_t kind) const {
    report::Demand all;
    all.kind = run_.kinds.at(kind);
    std::set<Robot> robots;
    for (const auto& [key, asked] : demanded_)
      if (key.first == kind) robots.insert(key.second);
    for (const auto& [key, jobs] : run_.jobs)
      if (key.first == kind) robots.insert(key.second);
    double time = 0;
    for (const Robot robot : robots) {
      const auto asked = demanded_.find({kind, robot});
      const auto own = run_.jobs.find({kind, robot});
      const std::uint64_t demanded = asked == demanded_.end() ? 0 : until(asked->second.released, run_.to);
      static const JobTimes none;
      const JobTimes& jobs = own == run_.jobs.end() ? none : own->second;
      all.demanded += demanded;
      const std::uint64_t released = jobs.released.size();
      all.released += released;
      all.misses += jobs.misses;
      all.not_demanded += demanded - std::min(demanded, released);
      all.extra += released - std::min(demanded, released);
      all.finished += jobs.finished.size();
      time += add_rate(kind, robot, jobs, all);
    }
    if (time > 0) {
      all.demanded_hz = static_cast<double>(all.demanded) / time;
      all.realised_hz = static_cast<double>(all.finished) / time;
    }
    return all;
  }

 private:
  /// \returns the time in which the kind is demanded of that robot, s; 0 for a kind without a rate
  double add_rate(std::size_t kind, Robot robot, const JobTimes& jobs, report::Demand& all) const {
    const auto is = [kind](JobKind other) { return kind == static_cast<std::size_t>(other); };
    std::vector<Interval> when;
    if (is(JobKind::pid) || is(JobKind::torque_compensation)) when = servoing(ideal_, run_.to);
    else if (is(JobKind::trajectory_crane) || is(JobKind::inverse_crane) || is(JobKind::trajectory_agv) || is(JobKind::inverse_agv)) when = legs(ideal_, robot, run_.to);
    for (Interval& interval : when) interval.to = std::max(interval.from, std::min(interval.to, run_.to));
    const Time whole = demanded_until(when, run_.to);
    if (whole == Time{}) return 0;
    std::vector<Time> finished;
    for (const Time time : jobs.finished) finished.push_back(demanded_until(when, time));
    std::ranges::sort(finished);
    const double worst = worst_rate(finished, whole);
    all.worst_hz = all.worst_hz ? std::min(*all.worst_hz, worst) : worst;
    return seconds(whole);
  }

  const Measured& run_;
  const Course& ideal_;
  const JobsByRobot& demanded_;
};

report::Demand sum(const report::Demand& a, const report::Demand& b) {
  const auto slower = [](std::optional<double> x, std::optional<double> y) { return x && y ? std::min(*x, *y) : x ? x : y; };
  return {a.kind + ", " + b.kind, a.demanded + b.demanded, a.released + b.released, a.misses + b.misses, a.not_demanded + b.not_demanded,
          a.extra + b.extra, a.finished + b.finished, slower(a.demanded_hz, b.demanded_hz), slower(a.realised_hz, b.realised_hz), slower(a.worst_hz, b.worst_hz)};
}

void add_demand(const Measured& run, const Course& ideal, const JobsByRobot& demanded, report::Errors& errors) {
  const DemandOf demand(run, ideal, demanded);
  for (std::size_t kind = 0; kind < run.kinds.size(); ++kind) {
    report::Demand one = demand.kind(kind);
    if (one.demanded + one.released > 0) errors.demand.push_back(std::move(one));
  }
  for (const RateKinds& row : rates_of(run.config)) {
    const auto first = demand.kind(static_cast<std::size_t>(row.first)), second = demand.kind(static_cast<std::size_t>(row.second));
    errors.rates.push_back({row.name, {first.kind, second.kind}, row.nominal_hz, sum(first, second)});
  }
}

}  // namespace

// A box of twelve metres turns about its middle. The gantry's psi does not move.
std::array<double, plant::joint_count> levers(const plant::CraneParameters& crane) {
  const double box = 0.5 * plant::container_length;
  if (crane.machine == plant::Machine::gantry) return {1.0, 0.0, 1.0, 1.0, box};
  return {1.0, crane.a0 + crane.jib, crane.jib, 1.0, box};
}

std::size_t latches_of(const Config& config) { return static_cast<std::size_t>(std::llround(config.run.duration_s / plant::latch_seconds)) + 1; }

report::Errors measure(const Measured& run, const Course& ideal, const JobsByRobot& demanded) {
  report::Errors errors;
  const Time from = ideal.servo_times().empty() ? Time{} : ideal.servo_times().front();
  errors.from = from;
  errors.to = run.to;
  const auto names = plant::joint_names(run.dock.crane.machine);
  const auto weights = levers(run.dock.crane);
  Progress progress(run.course, ideal, 0, from, run.to);

  Sampled load, nothing, alpha, beta;
  std::array<Sampled, plant::joint_count> error, path;
  std::vector<Sampled> agvs(static_cast<std::size_t>(run.dock.agv_count));
  std::vector<double> arrivals;  // ends of the crane's legs
  for (const Milestone& milestone : run.course.milestones()) {
    if (milestone.robot == 0 && milestone.kind() == Milestone::Kind::leg_ended) arrivals.push_back(seconds(milestone.at));
  }
  std::size_t arrival = 0;
  double weighed = 0;
  const double step = seconds(plant::latch_period);
  const bool both = run.course.size() > 0 && ideal.size() > 0;
  for (Time time = from; both && time < run.to; time += plant::latch_period) {
    const Row own = run.course.at(time), meant = ideal.at(time);
    const Time there = progress.ideal_time(time);
    load.add(distance(own, meant, load_column, 3));
    nothing.add(distance(meant, ideal.at(from), load_column, 3));
    for (std::size_t j = 0; j < error.size(); ++j) {
      const double off = own[j] - meant[j];
      error[j].add(off);
      path[j].add(own[j] - (there == time ? meant[j] : ideal.at(there, j)));
      weighed += weights[j] * weights[j] * off * off * step;
    }
    alpha.add(own[sway_column] - meant[sway_column]);
    beta.add(own[sway_column + 1] - meant[sway_column + 1]);
    while (arrival + 1 < arrivals.size() && arrivals[arrival + 1] <= seconds(time)) ++arrival;
    if (!arrivals.empty() && arrivals[arrival] <= seconds(time) && seconds(time) <= arrivals[arrival] + residual_seconds) {
      errors.residual_sway_rad = std::max(errors.residual_sway_rad.value_or(0), distance(own, meant, sway_column, 2));
    }
    for (std::size_t agv = 0; agv < agvs.size(); ++agv) agvs[agv].add(distance(own, meant, agv_column + 2 * agv, 2));
  }

  errors.load = load.told();
  errors.doing_nothing_m = nothing.told().rms;
  errors.error_m2s = weighed;
  for (std::size_t j = 0; j < error.size(); ++j) {
    if (weights[j] > 0) errors.joints.push_back({names[j].name, names[j].unit, error[j].told(), path[j].told()});
  }
  errors.sway = {{"alpha", "rad", alpha.told(), {}}, {"beta", "rad", beta.told(), {}}};
  for (std::size_t agv = 0; agv < agvs.size(); ++agv) errors.agvs.push_back({"agv " + std::to_string(agv), "m", agvs[agv].told(), {}});
  for (Robot robot = 0; robot <= static_cast<Robot>(run.dock.agv_count); ++robot) {
    const Progress of(run.course, ideal, robot, from, run.to);
    if (of.any()) errors.lags.push_back(of.lag(robot == 0 ? "crane" : "agv " + std::to_string(robot - 1)));
  }
  add_demand(run, ideal, demanded, errors);
  return errors;
}

std::map<Robot, std::uint64_t> starved_intervals(const Course& course, Time end) {
  struct Leg {
    Time since{}, interval{1};
    bool open = false;
  };
  std::map<Robot, Leg> legs;
  std::map<Robot, std::uint64_t> starved;
  std::size_t leg_number = 0;
  const auto gap = [&](Robot robot, Leg& leg, Time until) {
    if (leg.open && until > leg.since) starved[robot] += static_cast<std::uint64_t>(std::max<std::int64_t>(0, (until - leg.since) / leg.interval - 1));
    leg.since = std::max(leg.since, until);
  };
  for (const Milestone& milestone : course.milestones()) {
    Leg& leg = legs[milestone.robot];
    switch (milestone.kind()) {
      case Milestone::Kind::leg_begun: leg = {milestone.at, course.leg_intervals().at(leg_number++), true}; break;
      case Milestone::Kind::point: gap(milestone.robot, leg, milestone.at); break;
      case Milestone::Kind::leg_ended: leg.open = false; break;
      default: break;
    }
  }
  for (auto& [robot, leg] : legs) gap(robot, leg, end);
  for (const auto& [robot, leg] : legs) starved.try_emplace(robot, 0);
  return starved;
}

}  // namespace cmrc
