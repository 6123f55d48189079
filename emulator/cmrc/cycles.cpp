#include "cmrc/cycles.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cmrc {

using report::Time;

report::CycleReport* Cycles::of_agv(unsigned agv) {
  const Agv& known = agvs_[agv];
  return known.loaded ? &cycles_[known.cycle] : nullptr;
}

void Cycles::agv_waits(unsigned agv, bool waits, Time now) {
  Agv& of = agvs_[agv];
  if (waits && !of.waits_since) of.waits_since = now;
  if (!waits && of.waits_since) of.waited += now - *std::exchange(of.waits_since, std::nullopt);
}

void Cycles::sent(unsigned agv, std::int64_t interval) {
  if (auto* cycle = of_agv(agv)) cycle->agv_interval = interval;
}

void Cycles::process(unsigned number, bool started, unsigned robot, Time now) {
  if (started) started_[{number, robot}] = now;
  const auto lasted = [&] { return now - started_[{number, robot}]; };
  switch (number) {
    case 3:
      if (started) {
        cycles_.emplace_back();
        cycles_.back().number = static_cast<unsigned>(cycles_.size());
        asked_.reset();
      } else {
        cycles_.back().t3 = lasted();
        grabbed_ = now;
      }
      break;
    case 4:
      if (started) {
        loading_begins(robot - 1, now);
      } else if (auto* cycle = of_agv(robot - 1)) {
        cycle->t4 = lasted();
        cycle->T_g = *cycle->t3 + *cycle->t4 + *cycle->t_v;
      }
      break;
    case 5:
      if (auto* cycle = of_agv(robot - 1); cycle != nullptr && !started) cycle->t5 = lasted();
      break;
    case 6:
      if (started) {
        agvs_[robot - 1].waited = {};
      } else {
        Agv& agv = agvs_[robot - 1];
        if (!agv.waits_since) agv.waits_since = now;
        if (auto* cycle = of_agv(robot - 1)) {  // else it comes back from an empty round
          cycle->t6 = lasted() - agv.waited;
          ++completed_;
        }
      }
      break;
    default: break;
  }
}

void Cycles::loading_begins(unsigned number, Time now) {
  Agv& agv = agvs_[number];
  report::CycleReport& cycle = cycles_.back();
  const Time ready = asked_.value_or(grabbed_);
  const Time free = std::exchange(agv.waits_since, std::nullopt).value_or(Time{});  // those that wait at the start: always
  const Time met = std::max(ready, free);
  // Within process 3 the crane waits at "wait_for_agv", after it for whoever else has to consent to process 4.
  const Time within = asked_ ? met - ready : Time{};
  cycle.t_v = within + (now - grabbed_);
  *cycle.t3 -= within;
  if (auto* before = of_agv(number); before != nullptr && before->t6) {
    before->t_w = agv.waited + (met - free);
    before->approach = now - met;
    before->T_a = *before->t5 + *before->t6 + *before->t4 + *before->t_w + *before->approach;
    closed_ = AgvCycle{number, *before->t5 + *before->t6, *before->t_w, *cycle.t_v, *before->T_g};
  }
  agv.cycle = cycles_.size() - 1;
  agv.loaded = true;
  cycle.agv = number;
}

std::optional<AgvCycle> Cycles::take_closed() { return std::exchange(closed_, std::nullopt); }

std::int64_t learned_interval(const Config::Scheduling& rule, std::int64_t present, std::int64_t lowest, unsigned agvs, const AgvCycle& cycle) {
  if (rule.learning == Learning::off) return present;
  const auto driving = static_cast<double>(cycle.driving.count());
  const auto waiting = static_cast<double>(cycle.t_w.count()) - static_cast<double>(cycle.t_v.count()) * agvs;
  if (std::abs(waiting) <= rule.learning_dead_band * static_cast<double>(cycle.T_g.count())) return present;
  const auto n = static_cast<double>(present);
  double change = waiting > 0 ? 1 : -1;
  if (rule.learning == Learning::proportional) {
    const double target = n * (driving + waiting) / driving;
    const double most = rule.learning_step_max * n;
    change = std::clamp(std::round(rule.learning_rate * (target - n)), -most, most);
  }
  return std::clamp(present + static_cast<std::int64_t>(change), lowest, rule.agv_interval_max_refreshes);
}

}  // namespace cmrc
