// The host's software for failures: the watchdog, fencing, blocks that are put back or given up, a list that is not
// released.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cmrc/host/host.hpp"

namespace cmrc {

using report::EventKind;

std::int64_t Host::watchdog_limit(JobKind job) const {
  const auto gap = gaps_.find(job);
  const auto longest = static_cast<double>(gap != gaps_.end() ? gap->second : longest_.at(job));
  return std::max(config_.watchdog.minimum_refreshes,
                  static_cast<std::int64_t>(std::ceil(config_.watchdog.factor * longest)));
}

// Ticks since the last sign of life of a claimed block, also those without a refresh: since its present heartbeat was
// first read, or since it was first seen claimed. So a block that was claimed while the host was paused has age 0,
// whatever its t. Else t is one more: t + 1 follows in the same refresh (ruling 20). An age that reaches the limit is a
// t above it.
std::int64_t Host::age(const TaskBlock& block) const {
  return tick_ - (block.beat_seen < 0 ? block.seen : block.beat_seen);
}

void Host::alive_read(Word beat) {
  TaskBlock& block = list_[flags_.front()];
  if (block.beat_seen < 0 || beat != block.beat) {
    // Only the certain part counts as a gap: a late look says nothing about the time before it.
    if (std::int64_t& longest = gaps_.at(job_of(flags_.front())); block.beat_seen >= 0)
      longest = std::max(longest, block.running - block.beat_seen + 1);
    block.beat = beat;
    block.beat_seen = tick_;
  }
  block.running = tick_;
  judge();
}

void Host::judge() {
  const std::size_t index = flags_.front();
  if (age(list_[index]) >= watchdog_limit(job_of(index))) {
    step_ = Step::owner;
    port_->read(words_.block(index) + words_.owner, 1, 0);
  } else {
    flags_.pop_front();
    next_flag();
  }
}

// A read comes after all writes before it: the flag that it returns is the last word of a DSP that is fenced off. A DSP
// that was reset after its block had been seen claimed works on another block, and is left alone; so is one that was
// without a program since. A block first seen claimed after that may have been claimed before or after the reset. Then
// the reset is repeated, because a DSP left alone might continue with a block that has another owner now.
void Host::owner_read(Word owner) {
  const std::size_t index = flags_.front();
  suspect_.reset();
  if (owner >= 1 && owner <= renewed_.size()) {
    const unsigned slot = owner - 1;
    if (renewed_[slot] <= list_[index].resets) suspect_ = slot;
  }
  if (suspect_) fence_off(*suspect_);
  step_ = Step::verdict;
  port_->read(words_.block(index) + words_.flag, 1, 0);
}

void Host::verdict_read(Word flag) {
  if (flag == words_.flag_done) {    // late, but before the watchdog acted
    if (suspect_) renew(*suspect_);  // it may have begun its next claim, of which words were refused
    step_ = Step::result;
    port_->read(words_.block(flags_.front()) + words_.result, 2, 0);
    return;
  }
  hung_.push_back({flags_.front(), suspect_, age(list_[flags_.front()])});
  flags_.pop_front();
  next_flag();
}

void Host::recompute(const Hung& hung) {
  const TaskBlock& block = list_[hung.block];
  listener_.failure(
      {now_, hung.slot, "watchdog",
       fmt::format("block {:#x} of kind {} {} and is not done", words_.block(hung.block),
                   ledger_.name(job_of(hung.block)),
                   block.beat_seen < 0 ? fmt::format("was taken {} refreshes ago", hung.age)
                                       : fmt::format("has had no heartbeat for {} refreshes", hung.age))});
  if (static_cast<std::int64_t>(block.recomputations) < config_.watchdog.recomputations_max) {
    ++list_[hung.block].recomputations;
    list_.put_back(hung.block, row_of(JobKind::recompute).x);
    ledger_.put_back(hung.block, now_);
    ++counts_.recomputed;
    note(EventKind::requeue,
         {words_.block(hung.block), block.task.kind, block.generation, hung.slot.value_or(0xFF), block.recomputations});
  } else {
    give_up(hung.block);
  }
  if (hung.slot) renew(*hung.slot);
}

// ---- signs of life ----

std::int64_t Host::silence_limit() const {
  return static_cast<std::int64_t>(std::ceil(config_.watchdog.silence_ms * 1e-3 * config_.rates.refresh_frequency_hz));
}

void Host::after_flags() {
  const std::int64_t limit = silence_limit();
  if (limit == 0 || config_.machine.idle_policy != IdlePolicy::doorbell || !liveness_.doubtful(looks(), limit))
    return next_field();
  if (signs_.empty()) return judge_silence();
  step_ = Step::signs;
  port_->read(words_.block(signs_.front()) + words_.owner, 1, 0);
}

void Host::sign_read(Word owner) {
  if (owner >= 1 && owner <= renewed_.size()) liveness_.sign(owner - 1, looks());
  signs_.pop_front();
  if (signs_.empty())
    judge_silence();
  else
    port_->read(words_.block(signs_.front()) + words_.owner, 1, 0);
}

void Host::judge_silence() {
  for (const auto& [slot, verdict] : liveness_.judge(looks(), silence_limit())) {
    const bool silent = verdict == Liveness::Verdict::silent;
    listener_.failure({now_, slot, "silent",
                       silent ? fmt::format("no sign of life for {} ms: it is reset", config_.watchdog.silence_ms)
                              : fmt::format("no sign of life for {} ms after its reset: it is considered dead",
                                            config_.watchdog.silence_ms)});
    if (silent) renew(slot);
  }
  next_field();
}

// ---- blocks that are given up ----

void Host::give_up(std::size_t index) {
  const Task task = list_[index].task;
  listener_.failure({now_, std::nullopt, "dropped block",
                     fmt::format("block {:#x} of kind {} hung {} times and is given up", words_.block(index),
                                 ledger_.name(job_of(index)), list_[index].recomputations + 1)});
  note(EventKind::remove, {words_.block(index), task.kind, list_[index].generation, 0, 0});
  note(EventKind::miss,
       {task.kind, task.tick, static_cast<std::uint32_t>(report::Outcome::dropped), words_.block(index), 0});
  list_.remove(index);
  ledger_.dropped(index, now_);
  servo_.given_up(index);
  if (task.kind == words_.program(JobKind::error)) return errors_.undecided(task, now_, *this);
  const std::int64_t drops = ++drops_[{task.kind, task.robot}];
  errors_.given_up(task, drops <= config_.watchdog.retries_max, now_, *this);
}

void Host::fence_off(unsigned slot) {
  fence_ &= ~(Word{1} << slot);
  port_->write(words_.fence_mask, fence_);
}

void Host::renew(unsigned slot) {
  // A reset ends the DSP's work and drops the words in its bridge; afterwards it may write again.
  port_->write(words_.reset_dsp, Word{slot});
  listener_.reset_by_watchdog(slot);
  fence_ |= Word{1} << slot;
  port_->write(words_.fence_mask, fence_);
  renewed_[slot] = ++resets_;
  liveness_.renewed(slot, looks());
}

// ---- the list's semaphore ----

// Different DSPs may have held the list during this time; only one that keeps it counts as dead.
void Host::held_read(Word microseconds) {
  refused_since_ = now_;
  if (static_cast<double>(microseconds) < config_.watchdog.semaphore_limit_us) return try_again();
  held_for_ = microseconds;
  step_ = Step::holder;
  port_->read(words_.semaphore_owner + words_.semaphore_list - words_.semaphore, 1, 0);
}

// The holder is fenced off. Then the host acquires the list, unless it has just been released to another DSP, and
// resets the DSP that it has fenced off: this DSP must not continue its claim when it wakes.
void Host::holder_read(Word owner) {
  if (owner < 1 || owner > renewed_.size()) return try_again();  // it was released meanwhile
  holder_ = owner - 1;
  fence_off(*holder_);
  acquire();
}

void Host::take_from_holder(bool taken) {
  const unsigned slot = *holder_;
  renew(slot);
  if (!taken) return holder_.reset();
  ++counts_.semaphores_freed;
  pointer_in_doubt_ = true;
  note(EventKind::semaphore, {0, 2, slot + 1, 0, 0});
  listener_.failure(
      {now_, slot, "semaphore", fmt::format("the list was held for {} us; the host released it", held_for_)});
}

}  // namespace cmrc
