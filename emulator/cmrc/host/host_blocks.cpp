// The host's software for blocks: loading, writing, holding back and taking out.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

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

void Host::drop_tick(const Task& task, const NominalTick& tick, std::size_t block, report::Wait cause) {
  note(EventKind::miss,
       {task.kind, task.tick, static_cast<std::uint32_t>(report::Outcome::dropped), words_.block(block), 0});
  ledger_.skipped(job_kind(task.kind, words_), clock_.at(tick.released), clock_.at(tick.deadline), tick.number, now_,
                  task.robot, cause);
}

void Host::write(Word offset, std::span<const Word> words) { port_->write(offset, words); }

// PID and torque compensation take their set-points at TB_TICK, and read their sensors when they run. A block that was
// put back would join the set-points of then to the sensors of now. So it is of the refresh that offers it.
Word Host::tick_of(const TaskBlock& block) const {
  const auto now = static_cast<Word>(tick_), nominal = block.task.tick;
  const bool late = block.recomputations > 0 && static_cast<std::int32_t>(now - nominal) > 0;
  return late && servo_.owns(block.task) ? now : nominal;
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
                                block.task.kind == words_.program(JobKind::pid) && servo_.torque_is_behind(block.task);
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
  servo_.finished(done.block, t);
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

void Host::count_rest(Time end, Ledger& account) const {
  if (refresh_at_ == machine::never) return;                   // it has not begun
  const std::int64_t last = clock_.tick_at_or_after(end) - 1;  // refresh before the end
  const auto in_the_way = [&](const Task& task) {
    return std::ranges::any_of(list_.order(), [&](std::size_t index) {
      const Task& other = list_[index].task;
      return other.kind == task.kind && other.robot == task.robot && other.subprocess == task.subprocess &&
             account.is_open(index);
    });
  };
  const auto count = [&](const Task& task, std::int64_t released, std::optional<Time> deadline,
                         std::optional<std::int64_t> number, std::optional<report::Wait> dropped) {
    const JobKind job = job_kind(task.kind, words_);
    if (dropped)
      account.skipped(job, clock_.at(released), deadline, number, end, task.robot, *dropped);
    else
      account.never_loaded(job, clock_.at(released), deadline, number, end, task.robot);
  };
  const auto late = [](bool dropped) { return dropped ? std::optional(report::Wait::host_late) : std::nullopt; };
  servo_.each_passed(
      last, [&](std::size_t block) { return account.is_open(block); },
      [&](const Task& task, const NominalTick& tick, std::optional<report::Wait> dropped) {
        count(task, tick.released, clock_.at(tick.deadline), tick.number, dropped);
      });
  processes_.each_passed(last, in_the_way,
                         [&](const Task& task, std::int64_t due, std::int64_t deadline, bool dropped) {
                           count(task, due, clock_.at(deadline), std::nullopt, late(dropped));
                         });
  user_tasks_.each_passed(last, in_the_way,
                          [&](const Task& task, std::int64_t due, std::optional<Time> allowed, bool dropped) {
                            count(task, due, allowed ? std::optional(clock_.at(due) + *allowed) : std::nullopt,
                                  std::nullopt, late(dropped));
                          });
}

}  // namespace cmrc
