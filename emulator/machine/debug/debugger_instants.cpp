// To an instant: snapshots, runs from them, and hits that have already happened there.
#include "machine/debug/debugger.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "machine/debug/debugger_shared.hpp"
#include "machine/debug/hit_recorder.hpp"

namespace machine::debug {
namespace {

constexpr Time replay_slice = std::chrono::milliseconds{20};

/// Without a step's breakpoint, of which no hit can be outstanding.
std::map<unsigned, Trigger> lasting(std::map<unsigned, Trigger> triggers) {
  if (const auto step = triggers.find(temporary); step != triggers.end() && step->second.kind == Trigger::Kind::code)
    triggers.erase(step);
  return triggers;
}

}  // namespace

/// Runs there, repeats the changes by hand that lie on the way, and keeps snapshots.
void Debugger::run_to(Time time) {
  const Time from = now();
  const auto make_changes = [&] {
    while (changed_ < changes_.size() && changes_[changed_].time <= now()) changes_[changed_++].make();
  };
  make_changes();
  while (now() < time && !asked_to_stop() && !debuggee_.over()) {
    Time next = std::min(time, now() + replay_slice);
    if (changed_ < changes_.size()) next = std::min(next, changes_[changed_].time);
    debuggee_.run_until(next);
    make_changes();
    if (history_->due(now())) {
      const auto begin = std::chrono::steady_clock::now();
      const std::string state = debuggee_.save();
      history_->add({now(), changed_}, state, std::chrono::steady_clock::now() - begin);
    }
    if (progress) progress(now(), from, time);
  }
}

void Debugger::load_before(Time time) {
  const auto place = history_->before(time);
  if (!place) throw std::logic_error("no snapshot lies before an instant of the run");
  debuggee_.load(history_->state_before(time));
  changed_ = place->changes;
}

void Debugger::move_to(Time time) {
  recorder_->close();
  heard_at_.reset();
  if (time < now()) load_before(time);
  run_to(time);
}

/// The same; later hits that have already happened are kept for the next search.
void Debugger::move_and_listen(Time time, const Manner& manner) {
  recorder_->close();
  if (time < now()) {
    load_before(time);
    recorder_->arm(triggers_, manner.steps);
    recorder_->listen(time);
    run_to(time);
  }
  heard_at_ = now();
  heard_for_ = lasting(triggers_);
}

/// To be called before a search: hits after now that have already happened.
void Debugger::hear_what_is_under_way(const Manner& manner) {
  const auto same = [](const auto& a, const auto& b) { return a.first == b.first && a.second.same_as(b.second); };
  if (heard_at_ == now() && std::ranges::equal(heard_for_, lasting(triggers_), same)) {
    recorder_->rearm(triggers_, manner.steps);
    return;
  }
  const bool needed = std::ranges::any_of(
      triggers_, [](const auto& entry) { return entry.second.enabled && entry.second.kind != Trigger::Kind::code; });
  const Time here = now();
  if (needed && here > beginning()) load_before(here - Time{1});
  recorder_->arm(triggers_, manner.steps);
  recorder_->listen(here);
  run_to(here);
  recorder_->stepped.reset();
}

const Stop& Debugger::go_to(Time time) {
  interrupted_ = false;
  time = std::max(time, beginning());
  if (debuggee_.over() && time >= now()) return ended();
  // A later instant; but perhaps a snapshot lies between.
  if (const auto place = history_->before(time); place && place->time > now()) recorder_->close(), load_before(time);
  move_to(time);
  if (now() < time) {
    if (debuggee_.over()) return ended();
    return paused();
  }
  return stopped(Stop::Reason::moved, {}, fmt::format("at {}", seconds(now())));
}

Time Debugger::beginning() const { return history_->info().first; }
HistoryInfo Debugger::history() const { return history_->info(); }

}  // namespace machine::debug
