// The host's software for blocks: loading, writing, holding back and taking out, and the servo's releases.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "cmrc/configuration/clock_deviations.hpp"
#include "cmrc/host/host.hpp"

namespace cmrc {

using report::EventKind;

std::size_t Host::place_in_list(const Task& task) {
  try {
    return list_.load(task);
  } catch (const ListFull& full) {
    throw ListFull(fmt::format(
        "the host at {:.9f} s, refresh {}: no place for a block of kind {}: {}; fewer sub-processes, tasks or AGVs are "
        "expected",
        report::seconds(now_), tick_, ledger_.name(job_kind(task.kind, words_)), full.what()));
  }
}

std::size_t Host::load_block(const Task& task, JobKind job, Time released, std::optional<Time> deadline,
                             std::optional<std::int64_t> number) {
  const std::size_t index = place_in_list(task);
  ledger_.release(index, job, released, deadline, number, task.robot);
  note(EventKind::load, {words_.block(index), task.kind, task.area, task.tick, list_[index].generation});
  return index;
}

void Host::load(const Task& asked, std::optional<std::int64_t> deadline) {
  Task task = asked;
  task.deadline = deadline;
  load_block(task, job_kind(task.kind, words_), clock_.at(tick_),
             deadline ? std::optional(clock_.at(*deadline)) : std::nullopt, std::nullopt);
}

void Host::drop_block(const Task& task, std::int64_t due, std::optional<Time> deadline) {
  const auto order = list_.order();
  const auto before = std::ranges::find_if(order, [&](std::size_t index) {
    return list_[index].task.kind == task.kind && list_[index].task.robot == task.robot;
  });
  note(EventKind::miss,
       {task.kind, static_cast<std::uint32_t>(due), static_cast<std::uint32_t>(report::Outcome::dropped),
        before == order.end() ? 0 : words_.block(*before), 0});
  ledger_.skipped(job_kind(task.kind, words_), clock_.at(due), deadline, std::nullopt, now_, task.robot);
}

void Host::write(Word offset, std::span<const Word> words) { port_->write(offset, words); }

// PID and torque compensation take their set-points at TB_TICK, and read their sensors when they run. A block that was
// put back would join the set-points of then to the sensors of now. So it is of the refresh that offers it.
Word Host::tick_of(const TaskBlock& block) const {
  const auto now = static_cast<Word>(tick_), nominal = block.task.tick;
  const bool servo = block.task.kind == words_.program(JobKind::pid) ||
                     block.task.kind == words_.program(JobKind::torque_compensation);
  return servo && block.recomputations > 0 && static_cast<std::int32_t>(now - nominal) > 0 ? now : nominal;
}

void Host::write_new_blocks() {
  for (const std::size_t index : list_.order()) {
    TaskBlock& block = list_[index];
    if (!block.fresh) continue;
    block.fresh = false;
    std::array<Word, 16> words{};
    words[words_.x] = block.task.x;
    words[words_.y] = block.task.y;
    words[words_.t] = static_cast<Word>(block.t);
    words[words_.flag] = words_.flag_waiting;
    words[words_.importance] = block.importance;
    words[words_.kind] = block.task.kind;
    words[words_.area] = block.task.area;
    words[words_.tick] = tick_of(block);
    words[words_.argument] = block.task.argument;
    if (const auto own = own_slot(index)) words[words_.owner] = *own + 1;
    words[words_.generation] = block.generation;
    words[words_.slice] = block.task.slice;
    // The word of the slice is written only if a task is or was split.
    const bool split = std::exchange(block.written_slice, block.task.slice) != block.task.slice;
    port_->write(words_.block(index), std::span(words).first((split ? words_.slice : words_.notify) + 1));
  }
}

std::uint32_t Host::importance_of(const TaskBlock& block) const {
  const bool waits_for_torque = config_.scheduling.pid_after_torque &&
                                block.task.kind == words_.program(JobKind::pid) && torque_.out &&
                                static_cast<std::int32_t>(list_[torque_.block].task.tick - block.task.tick) <= 0;
  if (waits_for_torque && block.flag == Flag::waiting) return 0;
  if (user_tasks_.is_one(block.task) && block.task.x != row_of(JobKind::recompute).x)
    return importance(user_tasks_.row(block.task), block.t);
  ImportanceParameters parameters = parameters_;
  parameters.n_crane = processes_.crane().interval();
  if (block.task.robot > 0) parameters.n_agv = processes_.fleet().interval(block.task.robot - 1);
  return importance(parameters, block.task.x, block.task.y, block.t);
}

bool Host::is_long(const TaskBlock& block) const {
  return 2 * longest_.at(job_kind(block.task.kind, words_)) > intervals_.servo;
}

// Long blocks beyond the limit must not run yet: J = 0, until another long block is finished (plant-and-bus.md 4.6 item
// 4). A block for one DSP alone may wait for that DSP forever: it is neither counted nor held back.
void Host::hold_back_long_blocks() {
  std::int64_t room = config_.scheduling.long_blocks_max;
  if (room == 0) return;
  bool held = false;
  for (const std::size_t index : list_.order()) {  // claimed blocks come first
    TaskBlock& block = list_[index];
    if (own_slot(index) || !is_long(block) || block.importance == 0 || --room >= 0 || block.flag != Flag::waiting)
      continue;
    block.importance = 0;
    held = true;
  }
  if (held) list_.sort();
}

void Host::take_out(const Done& done) {
  const TaskBlock& block = list_[done.block];
  const Task task = block.task;
  const JobKind job = job_kind(task.kind, words_);
  const std::int64_t t = block.t + grown_;
  // Only the certain part: a pause of the host between two refreshes may have come after the end.
  longest_[job] = std::max(longest_[job], block.seen < 0 ? 1 : block.running - block.seen + 2);
  note(EventKind::remove, {words_.block(done.block), task.kind, block.generation, 0, 0});
  drops_.erase({task.kind, task.robot});
  const std::uint32_t own_x = block.own_x;
  list_.remove(done.block);
  if ((done.notify & words_.must_continue) != 0) return load_next_part(done.block, task, own_x);
  const report::Outcome outcome = ledger_.removed(done.block);
  if (outcome != report::Outcome::on_time) {
    note(EventKind::miss, {task.kind, task.tick, static_cast<std::uint32_t>(outcome), words_.block(done.block), 0});
  }
  if (task.kind == words_.program(JobKind::error)) return errors_.decided(task, done.result, now_, *this);
  if (task.kind == words_.program(JobKind::pid))
    pid_ended_ = now_, ++pid_runs_, control_.pid_ended(done.notify >> words_.pide_rests);
  if (task.kind == words_.program(JobKind::pid) && (done.notify & ~(~Word{0} << words_.pide_rests)) != 0)
    errors_.pid_says(done.notify, task.tick, now_, *this);
  if (task.kind == words_.program(JobKind::pid) && (done.result & words_.pid_starved) != 0) {
    note(EventKind::starved, {0, done.result & 0xFFFF, 0, 0, 0});
  }
  for (Servo* servo : {&torque_, &pid_}) {
    if (servo->out && servo->block == done.block) servo->out = false, servo->last_t = t;
  }
  if (user_tasks_.owns(task)) {
    user_tasks_.ended(task);
  } else {
    processes_.finished(task, done.result, done.notify, *this);
  }
}

// The same job continues in a block of its own.
void Host::load_next_part(std::size_t done, const Task& task, std::uint32_t own_x) {
  Task next = task;
  next.x = own_x;
  ++next.slice;
  next.t = 0;
  const std::size_t index = place_in_list(next);
  ledger_.continued(done, index, now_);
  note(EventKind::load, {words_.block(index), next.kind, next.area, next.tick, list_[index].generation});
}

// ---- the servo ----

void Host::refresh_servo(Servo& servo, bool on) {
  if (!on) {
    while (servo.next <= tick_) servo.next += intervals_.servo;
  } else if (servo.out || servo.waits || stopped(servo)) {
    while (servo.next <= tick_) drop_tick(servo);
  } else {
    while (servo.next + intervals_.servo <= tick_ || (servo.next <= tick_ && left_out(servo.next))) drop_tick(servo);
    if (!left_out(servo.next)) load_servo(servo);
  }
}

void Host::load_servo(Servo& servo) {
  const std::int64_t gamma = config_.scheduling.gamma_refreshes;
  Task task = servo.task;
  std::int64_t due = servo.next;
  if (config_.scheduling.servo_reload == ServoReload::locked) {
    task.t = tick_ - grown_ - (due - intervals_.servo);  // the refresh adds the elapsed refreshes
  } else {
    task.t = servo.last_t - grown_;
    due = std::max(tick_, tick_ + intervals_.servo - gamma - servo.last_t) + gamma;
  }
  task.tick = static_cast<std::uint32_t>(due);
  servo.block =
      load_block(task, servo.job, release_of_tick(due), clock_.at(due + intervals_.servo), due / intervals_.servo);
  servo.out = true;
  servo.next = due + intervals_.servo;
}

// One draw for each group of ticks, from the seed and the group's number alone: the same ticks for any number of DSPs.
bool Host::left_out(std::int64_t tick) const {
  const Config::Scheduling& s = config_.scheduling;
  const std::int64_t number = tick / intervals_.servo;
  if (number % s.servo_served_every != 0) return true;
  if (s.servo_loss_share <= 0) return false;
  return unit_draw(static_cast<std::uint64_t>(config_.run.seed), "servo_loss",
                   static_cast<std::uint64_t>(number / s.servo_loss_run)) < s.servo_loss_share;
}

bool Host::released(const Servo& servo) const { return processes_.releases(servo.subprocess, servo.task.robot); }

void Host::drop_tick(Servo& servo) {
  note(EventKind::miss, {servo.task.kind, static_cast<std::uint32_t>(servo.next),
                         static_cast<std::uint32_t>(report::Outcome::dropped), words_.block(servo.block), 0});
  skip(servo, servo.next, tick_, now_, ledger_);
  servo.next += intervals_.servo;
}

void Host::skip(const Servo& servo, std::int64_t tick, std::int64_t refresh, Time found, Ledger& ledger) const {
  const bool passed = tick + intervals_.servo <= refresh;
  const report::Wait cause = left_out(tick)                               ? report::Wait::left_out
                             : !passed && (servo.waits || stopped(servo)) ? report::Wait::stopped_by_error
                                                                          : report::Wait::host_late;
  ledger.skipped(servo.job, release_of_tick(tick), clock_.at(tick + intervals_.servo), tick / intervals_.servo, found,
                 servo.task.robot, cause);
}

void Host::count_rest(Time end, Ledger& account) const {
  if (refresh_at_ == machine::never) return;                   // it has not begun
  const std::int64_t last = clock_.tick_at_or_after(end) - 1;  // refresh before the end
  for (const Servo* servo : {&torque_, &pid_}) {
    if (!released(*servo)) continue;
    const bool blocked = servo->waits || stopped(*servo) || (servo->out && account.is_open(servo->block));
    const std::int64_t period = intervals_.servo;
    for (std::int64_t next = servo->next; next - config_.scheduling.gamma_refreshes <= last; next += period) {
      if (next + period <= last || (blocked && next <= last) || left_out(next))
        skip(*servo, next, last, end, account);
      else
        account.never_loaded(servo->job, release_of_tick(next), clock_.at(next + period), next / period, end);
    }
  }
  const auto in_the_way = [&](const Task& task) {
    return std::ranges::any_of(list_.order(), [&](std::size_t index) {
      const Task& other = list_[index].task;
      return other.kind == task.kind && other.robot == task.robot && other.subprocess == task.subprocess &&
             account.is_open(index);
    });
  };
  const auto count = [&](const Task& task, std::int64_t due, std::optional<Time> deadline, bool dropped) {
    const JobKind job = job_kind(task.kind, words_);
    if (dropped)
      account.skipped(job, clock_.at(due), deadline, std::nullopt, end, task.robot);
    else
      account.never_loaded(job, clock_.at(due), deadline, std::nullopt, end, task.robot);
  };
  processes_.each_passed(last, in_the_way,
                         [&](const Task& task, std::int64_t due, std::int64_t deadline, bool dropped) {
                           count(task, due, clock_.at(deadline), dropped);
                         });
  user_tasks_.each_passed(
      last, in_the_way, [&](const Task& task, std::int64_t due, std::optional<Time> allowed, bool dropped) {
        count(task, due, allowed ? std::optional(clock_.at(due) + *allowed) : std::nullopt, dropped);
      });
}

bool Host::servo_resting() const {
  // A waiting block whose J in shared memory is 0 cannot be claimed before the next relink, which comes after all
  // writes of this refresh.
  const auto rests = [this](const Servo& servo) {
    return !servo.out || (list_[servo.block].flag == Flag::waiting && list_[servo.block].importance == 0);
  };
  return rests(torque_) && rests(pid_);
}

}  // namespace cmrc
