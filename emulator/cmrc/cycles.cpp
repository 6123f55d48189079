#include "cmrc/cycles.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cmrc {

report::CycleReport* Cycles::of_agv(unsigned agv) {
  const auto found = agv_cycle_.find(agv);
  return found == agv_cycle_.end() ? nullptr : &cycles_[found->second];
}

void Cycles::crane_waits(bool waits, report::Time now) {
  if (waits && !waiting_since_) waiting_since_ = now;
  if (!waits && waiting_since_) waiting_ += now - *std::exchange(waiting_since_, std::nullopt);
}

void Cycles::process(unsigned number, bool started, unsigned robot, report::Time now) {
  if (started) started_[{number, robot}] = now;
  const auto lasted = [&] { return now - started_[{number, robot}]; };
  switch (number) {
    case 3:
      if (started) {
        cycles_.emplace_back();
        cycles_.back().number = static_cast<unsigned>(cycles_.size());
        waiting_ = {};
      } else {
        cycles_.back().t3 = lasted() - waiting_;
        crane_ready_ = now;
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
      if (auto* cycle = of_agv(robot - 1); cycle != nullptr && !started) {
        cycle->t6 = lasted();
        agv_free_[robot - 1] = now;
        ++completed_;
      }
      break;
    default: break;
  }
}

void Cycles::loading_begins(unsigned agv, report::Time now) {
  if (auto* before = of_agv(agv); before != nullptr && before->t6) {
    before->t_w = now - agv_free_[agv];
    before->T_a = *before->t5 + *before->t6 + *before->t4 + *before->t_w;
    closed_ = *before;
  }
  agv_cycle_[agv] = cycles_.size() - 1;
  cycles_.back().agv = agv;
  cycles_.back().t_v = waiting_ + (now - crane_ready_);
}

std::optional<report::CycleReport> Cycles::take_closed() { return std::exchange(closed_, std::nullopt); }

std::int64_t learned_interval(const Config::Scheduling& rule, std::int64_t present, std::int64_t lowest, unsigned agvs,
                              const report::CycleReport& cycle) {
  if (rule.learning == Learning::off || !cycle.t5 || !cycle.t6 || !cycle.t_w || !cycle.t_v || !cycle.T_g) return present;
  const auto driving = static_cast<double>((*cycle.t5 + *cycle.t6).count());
  const auto t_w = static_cast<double>(cycle.t_w->count());
  const auto t_v = static_cast<double>(cycle.t_v->count()) * agvs;
  const double waiting = t_w > 0 ? t_w : -t_v;
  if (std::abs(waiting) <= rule.learning_dead_band * static_cast<double>(cycle.T_g->count())) return present;
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
