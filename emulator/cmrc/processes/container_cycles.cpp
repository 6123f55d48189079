#include "cmrc/processes/container_cycles.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "state/visitor.hpp"

namespace cmrc {

using report::Time;

report::CycleReport* ContainerCycles::of_agv(unsigned agv) {
  const Agv& known = agvs_[agv];
  return known.cycle ? &cycles_[*known.cycle] : nullptr;
}

void ContainerCycles::agv_waits(unsigned agv, bool waits, Time now) {
  Agv& of = agvs_[agv];
  if (waits && !of.waits_since) of.waits_since = now;
  if (!waits && of.waits_since) of.waited += now - *std::exchange(of.waits_since, std::nullopt);
}

void ContainerCycles::sent(unsigned agv, std::int64_t interval) {
  if (auto* cycle = of_agv(agv)) cycle->agv_interval = interval;
}

void ContainerCycles::process(Account account, bool started, unsigned robot, Time now) {
  if (started) started_[{account, robot}] = now;
  const auto lasted = [&] { return now - started_[{account, robot}]; };
  switch (account) {
    case Account::none: break;
    case Account::t_3:
      if (started) {
        cycles_.emplace_back();
        cycles_.back().number = static_cast<unsigned>(cycles_.size());
        grabbed_.reset();
      } else {
        cycles_.back().t3 = lasted();
        grabbed_ = now;
      }
      break;
    case Account::t_4:
      if (started)
        loading_begins(robot - 1, now);
      else
        loading_ends(robot - 1, lasted());
      break;
    case Account::t_5:
      if (auto* cycle = of_agv(robot - 1); cycle != nullptr && !started) cycle->t5 = lasted();
      break;
    case Account::t_6:
      if (started) {
        agvs_[robot - 1].waited = {};
      } else {
        Agv& agv = agvs_[robot - 1];
        if (!agv.waits_since) agv.waits_since = now;
        if (auto* cycle = of_agv(robot - 1)) {  // else the AGV comes back from an empty round
          cycle->t6 = lasted() - agv.waited;
          ++completed_;
        }
      }
      break;
  }
}

void ContainerCycles::loading_begins(unsigned number, Time now) {
  Agv& agv = agvs_[number];
  agv.before = std::exchange(agv.cycle, std::nullopt);
  const auto since = std::exchange(agv.waits_since, std::nullopt);  // none: the AGV was there at the start
  if (!grabbed_) return;                                            // no process is accounted as t_3
  report::CycleReport& cycle = cycles_.back();
  cycle.t_v = now - *grabbed_;
  cycle.agv = number;
  agv.cycle = cycles_.size() - 1;
  if (!agv.before || !since) return;
  report::CycleReport& before = cycles_[*agv.before];
  before.t_w = agv.waited + (now - *since);
  if (before.t5 && before.t6 && before.T_g)
    closed_ = AgvCycle{number, *before.t5 + *before.t6, *before.t_w, *cycle.t_v, *before.T_g};
}

void ContainerCycles::loading_ends(unsigned number, Time lasted) {
  if (auto* cycle = of_agv(number)) {
    cycle->t4 = lasted;
    cycle->T_g = *cycle->t3 + *cycle->t4 + *cycle->t_v;
  }
  const auto before = std::exchange(agvs_[number].before, std::nullopt);
  if (!before || !cycles_[*before].t_w) return;
  report::CycleReport& closed = cycles_[*before];
  closed.t_wait = *closed.t_w + lasted;
  if (closed.t5 && closed.t6) closed.T_a = *closed.t5 + *closed.t6 + *closed.t_wait;
}

std::optional<AgvCycle> ContainerCycles::take_closed() { return std::exchange(closed_, std::nullopt); }

std::int64_t learned_interval(const Config::Scheduling& rule, std::int64_t present, std::int64_t lowest, unsigned agvs,
                              const AgvCycle& cycle) {
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

void ContainerCycles::list_state(state::Visitor& list) {
  list("cycles", cycles_);
  list("agvs", agvs_);
  list("started", started_);
  list("grabbed", grabbed_);
  list("closed", closed_);
  list("completed", completed_);
}

}  // namespace cmrc
