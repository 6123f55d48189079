#include "cmrc/measures/timeline.hpp"

#include <algorithm>
#include <iterator>

#include "state/visitor.hpp"

namespace cmrc {
namespace {

using report::Wait;

/// The entry valid at `time`, or the first one if all begin later.
template <class List>
auto at_time(const List& list, Time time) {
  const auto after =
      std::upper_bound(list.begin(), list.end(), time, [](Time t, const auto& entry) { return t < entry.from; });
  return after == list.begin() ? after : std::prev(after);
}

template <class List>
void drop_before(List& list, Time before) {
  if (list.empty()) return;
  for (auto second = std::next(list.begin()); second != list.end() && second->from <= before; ++second)
    list.pop_front();
}

std::int64_t& time_of(report::WaitTimes& times, Wait wait) { return times[static_cast<std::size_t>(wait)]; }

}  // namespace

void Timeline::change(unsigned number, State state) {
  if (slots_.size() <= number) slots_.resize(number + 1);
  auto& states = slots_[number].states;
  if (!states.empty()) state.from = std::max(state.from, states.back().from);
  states.push_back(std::move(state));
}

void Timeline::slot(unsigned number, SlotState state, Time at) {
  change(number, {at, state, {}});
  if (watcher_ != nullptr) watcher_->slot_is(number, state, at);
}

void Timeline::doorbell(unsigned number, SlotState state, Time at) {
  const bool off =
      number < slots_.size() && !slots_[number].states.empty() && slots_[number].states.back().state == SlotState::off;
  if (!off) slot(number, state, at);
}

void Timeline::took(unsigned number, const report::JobName& job, Time at) {
  change(number, {at, SlotState::busy, job});
}

void Timeline::left(unsigned number, const report::JobName& job, Time at) {
  if (number >= slots_.size() || slots_[number].states.empty()) return;
  const State& present = slots_[number].states.back();
  if (present.state == SlotState::busy && present.job == job) change(number, {at, SlotState::awake, {}});
}

void Timeline::list(unsigned owner, Time at) {
  holders_.push_back({at, owner});
  if (watcher_ != nullptr) watcher_->list(owner, at);
}

void Timeline::introduce(RunWatcher& watcher) const {
  for (unsigned i = 0; i < slots_.size(); ++i) {
    if (slots_[i].states.empty() || slots_[i].states.back().state == SlotState::busy) continue;
    watcher.slot_is(i, slots_[i].states.back().state, slots_[i].states.back().from);
  }
}

void Timeline::Slot::waited(const BusWait& wait) { waits.push_back(wait); }

void Timeline::forget(Time before) {
  for (Slot& slot : slots_) {
    drop_before(slot.states, before);
    while (!slot.waits.empty() && slot.waits.front().to <= before) slot.waits.pop_front();
  }
  drop_before(holders_, before);
}

// From `from` to `to` only this free DSP, which was awake, could have claimed the block.
void Timeline::wait_for_free(Time from, Time to, unsigned number, report::WaitTimes& times) const {
  auto holder = at_time(holders_, from);
  const auto& waits = slots_[number].waits;
  auto wait = std::lower_bound(waits.begin(), waits.end(), from, [](const BusWait& w, Time t) { return w.to <= t; });
  while (from < to) {
    const bool held = holder != holders_.end() && holder->from <= from;
    const bool locked = held && holder->owner != nobody && holder->owner != number + 1;
    const bool on_bus = wait != waits.end() && wait->from <= from;
    Time next = to;
    if (holder != holders_.end()) {
      const auto change = held ? std::next(holder) : holder;
      if (change != holders_.end()) next = std::min(next, change->from);
    }
    if (wait != waits.end()) next = std::min(next, on_bus ? wait->to : wait->from);
    const Wait cause = locked                               ? Wait::lock
                       : !on_bus                            ? Wait::claim
                       : wait->window == machine::Window::a ? Wait::claim_bus_a
                                                            : Wait::claim_bus_b;
    time_of(times, cause) += (next - from).count();
    from = next;
    while (holder != holders_.end() && std::next(holder) != holders_.end() && std::next(holder)->from <= from) ++holder;
    while (wait != waits.end() && wait->to <= from) ++wait;
  }
}

Waiting Timeline::explain(Time from, Time to, std::optional<unsigned> claimer, std::optional<unsigned> only) const {
  Waiting waiting;
  std::vector<std::deque<State>::const_iterator> states;
  for (const Slot& slot : slots_) states.push_back(at_time(slot.states, from));
  std::vector<unsigned> in_the_way;  // slots whose blocks are in the waiting block's way
  for (Time at = from; at < to;) {
    Time next = to;
    std::optional<unsigned> awake;  // the free DSP that is considered: the claimer, or the first
    bool asleep = false, overtaken = false;
    in_the_way.clear();
    for (unsigned i = 0; i < states.size(); ++i) {
      if (only && i != *only) continue;
      const auto& history = slots_[i].states;
      while (states[i] != history.end() && std::next(states[i]) != history.end() && std::next(states[i])->from <= at)
        ++states[i];
      if (states[i] == history.end()) continue;
      if (states[i]->from > at) {
        next = std::min(next, states[i]->from);
        continue;
      }
      if (std::next(states[i]) != history.end()) next = std::min(next, std::next(states[i])->from);
      switch (states[i]->state) {
        case SlotState::off: break;
        case SlotState::asleep: asleep = true; break;
        case SlotState::awake:
          if (!awake || i == claimer) awake = i;
          break;
        case SlotState::busy: {
          const bool later = states[i]->from >= from;
          if (later && !overtaken) in_the_way.clear();
          if (later || !overtaken) in_the_way.push_back(i);
          overtaken = overtaken || later;
          break;
        }
      }
    }
    const std::int64_t span = (next - at).count();
    if (awake) {
      wait_for_free(at, next, *awake, waiting.times);
    } else if (asleep) {
      time_of(waiting.times, Wait::doorbell) += span;
    } else if (in_the_way.empty()) {
      time_of(waiting.times, only ? Wait::own_dsp_out : Wait::no_dsp) += span;
    } else {
      time_of(waiting.times, overtaken ? Wait::behind_list : Wait::blocked) += span;
      const auto parts = static_cast<std::int64_t>(in_the_way.size());
      for (std::int64_t part = 0; part < parts; ++part) {
        const unsigned slot = in_the_way[static_cast<std::size_t>(part)];
        const State& state = *states[slot];
        const std::int64_t share = span / parts + (part < span % parts ? 1 : 0);
        const auto same = std::ranges::find_if(
            waiting.behind, [&](const report::BlockingJob& b) { return b.slot == slot && b.claimed == state.from; });
        if (same != waiting.behind.end()) {
          same->to = next;
          same->share += share;
        } else {
          waiting.behind.push_back({state.job, slot, state.from, at, next, share, overtaken});
        }
      }
    }
    at = next;
  }
  return waiting;
}

void Timeline::list_state(state::Visitor& list) {
  list("slots", slots_);
  list("holders", holders_);
}

}  // namespace cmrc
