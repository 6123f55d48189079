#include "cmrc/processes/servo_releases.hpp"

#include <algorithm>

#include "cmrc/configuration/machine/clock_deviations.hpp"
#include "state/visitor.hpp"

namespace cmrc {

ServoReleases::ServoReleases(const Config& config, const Words& words, const Processes& processes, const TaskList& list)
    : config_(config),
      processes_(processes),
      list_(list),
      period_(intervals(config).servo),
      torque_{task_of(JobKind::torque_compensation, words),
              config.processes.subprocess_of("torque_compensation").number, period_},
      pid_{task_of(JobKind::pid, words), config.processes.subprocess_of("pid").number, period_} {}

void ServoReleases::start(std::int64_t first) {
  for (Servo* servo : {&torque_, &pid_})
    while (servo->next < first) servo->next += period_;
}

void ServoReleases::refresh(std::int64_t grown, HostServices& services) {
  for (Servo* servo : {&torque_, &pid_}) refresh(*servo, grown, services);
}

// Ticks without servoing are not counted.
void ServoReleases::refresh(Servo& servo, std::int64_t grown, HostServices& services) {
  const std::int64_t now = services.tick();
  if (!released(servo)) {
    while (servo.next <= now) servo.next += period_;
  } else if (servo.out || servo.waits || stopped(servo)) {
    while (servo.next <= now) drop(servo, services);
  } else {
    while (servo.next + period_ <= now || (servo.next <= now && left_out(servo.next))) drop(servo, services);
    if (!left_out(servo.next)) load(servo, grown, services);
  }
}

void ServoReleases::load(Servo& servo, std::int64_t grown, HostServices& services) {
  const std::int64_t gamma = config_.scheduling.gamma_refreshes, now = services.tick();
  Task task = servo.task;
  std::int64_t due = servo.next;
  if (config_.scheduling.servo_reload == ServoReload::locked) {
    task.t = now - grown - (due - period_);  // the refresh adds the elapsed refreshes
  } else {
    task.t = servo.last_t - grown;
    due = std::max(now, now + period_ - gamma - servo.last_t) + gamma;
  }
  task.tick = static_cast<std::uint32_t>(due);
  servo.block = services.load_tick(task, nominal(due));
  servo.out = true;
  servo.next = due + period_;
}

void ServoReleases::drop(Servo& servo, HostServices& services) {
  Task task = servo.task;
  task.tick = static_cast<std::uint32_t>(servo.next);
  services.drop_tick(task, nominal(servo.next), servo.block, cause(servo, servo.next, services.tick()));
  servo.next += period_;
}

report::Wait ServoReleases::cause(const Servo& servo, std::int64_t tick, std::int64_t refresh) const {
  if (left_out(tick)) return report::Wait::left_out;
  const bool passed = tick + period_ <= refresh;
  return !passed && (servo.waits || stopped(servo)) ? report::Wait::stopped_by_error : report::Wait::host_late;
}

NominalTick ServoReleases::nominal(std::int64_t tick) const {
  return {tick / period_, tick - config_.scheduling.gamma_refreshes, tick + period_};
}

// One draw for each group of ticks, from the seed and the group's number alone: the same ticks for any number of DSPs.
bool ServoReleases::left_out(std::int64_t tick) const {
  const Config::Scheduling& s = config_.scheduling;
  const std::int64_t number = tick / period_;
  if (number % s.servo_served_every != 0) return true;
  if (s.servo_loss_share <= 0) return false;
  return unit_draw(static_cast<std::uint64_t>(config_.run.seed), "servo_loss",
                   static_cast<std::uint64_t>(number / s.servo_loss_run)) < s.servo_loss_share;
}

void ServoReleases::each_passed(std::int64_t last, const std::function<bool(std::size_t)>& open,
                                const Passed& passed) const {
  for (const Servo* servo : {&torque_, &pid_}) {
    if (!released(*servo)) continue;
    const bool blocked = servo->waits || stopped(*servo) || (servo->out && open(servo->block));
    for (std::int64_t next = servo->next; nominal(next).released <= last; next += period_) {
      const bool dropped = next + period_ <= last || (blocked && next <= last) || left_out(next);
      passed(servo->task, nominal(next), dropped ? std::optional(cause(*servo, next, last)) : std::nullopt);
    }
  }
}

void ServoReleases::finished(std::size_t block, std::int64_t t) {
  for (Servo* servo : {&torque_, &pid_}) {
    if (servo->out && servo->block == block) servo->out = false, servo->last_t = t;
  }
}

void ServoReleases::given_up(std::size_t block) {
  for (Servo* servo : {&torque_, &pid_}) {
    if (servo->out && servo->block == block) servo->out = false, servo->waits = true;
  }
}

bool ServoReleases::torque_is_behind(const Task& pid) const {
  return torque_.out && static_cast<std::int32_t>(list_[torque_.block].task.tick - pid.tick) <= 0;
}

// A waiting block whose J in shared memory is 0 cannot be claimed before the next relink, which comes after all writes
// of this refresh.
bool ServoReleases::rests(const Servo& servo) const {
  return !servo.out || (list_[servo.block].flag == Flag::waiting && list_[servo.block].importance == 0);
}

void ServoReleases::Servo::list_state(state::Visitor& list) {
  list("next", next);
  list("out", out);
  list("block", block);
  list("last_t", last_t);
  list("stopped", stopped);
  list("waits", waits);
}

void ServoReleases::list_state(state::Visitor& list) {
  list("torque", torque_);
  list("pid", pid_);
}

}  // namespace cmrc
