#include "cmrc/measures/demand.hpp"

#include <algorithm>
#include <set>

#include "cmrc/configuration/config.hpp"
#include "cmrc/measures/ledger.hpp"
#include "cmrc/processes/releases.hpp"
#include "cmrc/tasks/job_kinds.hpp"

namespace cmrc {

using report::seconds;

namespace {

struct Interval {
  Time from, to;
};

/// The times of a robot's legs, in which planning is demanded.
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
    if (i % 2 == 0)
      all.push_back({course.servo_times()[i], end});
    else
      all.back().to = course.servo_times()[i];
  }
  return all;
}

/// The demanded time that has passed at `time`: the time in which something is demanded, without the gaps.
Time demanded_until(const std::vector<Interval>& when, Time time) {
  Time sum{};
  for (const Interval& interval : when)
    if (time > interval.from) sum += std::min(time, interval.to) - interval.from;
  return sum;
}

/// The fewest finishes per second in any window of one second of the time in which they are demanded; a shorter time is
/// one window.
/// \param finished in demanded time, in order
double worst_rate(const std::vector<EventTimes::Group>& finished, Time whole) {
  constexpr Time window = std::chrono::seconds{1};
  std::vector<std::uint64_t> before{0};  // number of finishes before each
  for (const EventTimes::Group& some : finished) before.push_back(before.back() + some.count);
  const auto after = [&](Time time) {
    return static_cast<std::size_t>(std::ranges::upper_bound(finished, time, {}, &EventTimes::Group::time) -
                                    finished.begin());
  };
  const auto count = [&](Time from, Time to) {
    return static_cast<double>(before[after(to)] - before[after(from)]);
  };  // in ]from, to]
  if (whole <= window) return count(Time{-1}, whole) / seconds(whole);
  double worst = std::min(count(Time{-1}, window), count(whole - window, whole));
  for (const EventTimes::Group& some : finished) {
    if (some.time + window > whole) break;
    worst = std::min(worst, count(some.time, some.time + window));
  }
  return worst;
}

/// The kinds whose rates f_p, f_t and f_a are.
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

class DemandOf {
 public:
  DemandOf(const Measured& run, const Course& ideal, const JobsByRobot& demanded)
      : run_(run), ideal_(ideal), demanded_(demanded) {}

  report::Demand kind(std::size_t kind) const {
    report::Demand all;
    all.kind = run_.kinds.at(kind);
    std::set<Robot> robots;
    for (const auto& [key, asked] : demanded_)
      if (key.first == kind) robots.insert(key.second);
    for (const auto& [key, jobs] : run_.jobs)
      if (key.first == kind) robots.insert(key.second);
    double time = 0;
    const Time before_end = run_.to - Time{1};  // a release at the end belongs to no account
    for (const Robot robot : robots) {
      const auto asked = demanded_.find({kind, robot});
      const auto own = run_.jobs.find({kind, robot});
      const std::uint64_t demanded = asked == demanded_.end() ? 0 : asked->second.released.until(before_end);
      static const JobTimes none;
      const JobTimes& jobs = own == run_.jobs.end() ? none : own->second;
      all.demanded += demanded;
      const std::uint64_t released = jobs.released.until(before_end);
      all.released += released;
      all.misses += jobs.missed.until(before_end);
      all.not_demanded += demanded - std::min(demanded, released);
      all.extra += released - std::min(demanded, released);
      all.finished += jobs.finished.until(run_.to);
      time += add_rate(kind, robot, jobs, all);
    }
    if (time > 0) {
      all.demanded_hz = static_cast<double>(all.demanded) / time;
      all.realised_hz = static_cast<double>(all.finished) / time;
    }
    return all;
  }

 private:
  /// \returns the time in s in which the kind is demanded of that robot; 0 for a kind without a rate
  double add_rate(std::size_t kind, Robot robot, const JobTimes& jobs, report::Demand& all) const {
    const auto is = [kind](JobKind other) { return kind == static_cast<std::size_t>(other); };
    std::vector<Interval> when;
    if (is(JobKind::pid) || is(JobKind::torque_compensation))
      when = servoing(ideal_, run_.to);
    else if (is(JobKind::trajectory_crane) || is(JobKind::inverse_crane) || is(JobKind::trajectory_agv) ||
             is(JobKind::inverse_agv))
      when = legs(ideal_, robot, run_.to);
    for (Interval& interval : when) interval.to = std::max(interval.from, std::min(interval.to, run_.to));
    const Time whole = demanded_until(when, run_.to);
    if (whole == Time{}) return 0;
    std::vector<EventTimes::Group> finished = jobs.finished.in_order();
    std::erase_if(finished, [this](const EventTimes::Group& some) { return some.time > run_.to; });
    for (EventTimes::Group& some : finished) some.time = demanded_until(when, some.time);
    const double worst = worst_rate(finished, whole);
    all.worst_hz = all.worst_hz ? std::min(*all.worst_hz, worst) : worst;
    return seconds(whole);
  }

  const Measured& run_;
  const Course& ideal_;
  const JobsByRobot& demanded_;
};

report::Demand sum(const report::Demand& a, const report::Demand& b) {
  const auto slower = [](std::optional<double> x, std::optional<double> y) {
    return x && y ? std::min(*x, *y) : x ? x : y;
  };
  return {a.kind + ", " + b.kind,
          a.demanded + b.demanded,
          a.released + b.released,
          a.misses + b.misses,
          a.not_demanded + b.not_demanded,
          a.extra + b.extra,
          a.finished + b.finished,
          slower(a.demanded_hz, b.demanded_hz),
          slower(a.realised_hz, b.realised_hz),
          slower(a.worst_hz, b.worst_hz)};
}

}  // namespace

void add_demand(const Measured& run, const Course& ideal, const JobsByRobot& demanded, report::Errors& errors) {
  const DemandOf demand(run, ideal, demanded);
  for (std::size_t kind = 0; kind < run.kinds.size(); ++kind) {
    report::Demand one = demand.kind(kind);
    if (one.demanded + one.released > 0) errors.demand.push_back(std::move(one));
  }
  for (const RateKinds& row : rates_of(run.config)) {
    const auto first = demand.kind(static_cast<std::size_t>(row.first)),
               second = demand.kind(static_cast<std::size_t>(row.second));
    errors.rates.push_back({row.name, {first.kind, second.kind}, row.nominal_hz, sum(first, second)});
  }
}

}  // namespace cmrc
