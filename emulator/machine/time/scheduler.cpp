#include "machine/time/scheduler.hpp"

#include <algorithm>
#include <cassert>

namespace machine {

void Scheduler::add(Actor& actor) {
  actor.scheduler_ = this;
  actor.place_ = calendar_.add();
  actors_.push_back(&actor);
  actor.changed();
}

void Scheduler::add(Processor& processor) {
  add(static_cast<Actor&>(processor));
  processors_.push_back(&processor);
}

void Scheduler::enter(const Actor& actor, Time next) {
  calendar_.set(actor.place_, next);
  others_ = std::min(others_, next);
}

void Scheduler::all_changed() {
  for (Actor* actor : actors_) actor->changed();
}

// In any order and to any instant.
void Scheduler::run_some_ahead(Time limit) {
  if (!shuffle_.active()) return;
  limit_ = limit;
  for (std::size_t i = 0; i < processors_.size(); ++i) {
    Processor& processor = *processors_[shuffle_.below(processors_.size())];
    if (!processor.runs()) continue;
    const Time next = processor.next(), far = std::min(limit_, processor.horizon());
    if (next >= far) continue;
    const auto span = static_cast<std::uint64_t>((far - next).count());
    processor.run_ahead(next + Time{1 + static_cast<std::int64_t>(shuffle_.below(span))});
    processor.changed();
  }
}

inline bool Scheduler::turn(Time limit, Length length) {
  const EventCalendar::Turn turn = calendar_.earliest();
  if (turn.time >= limit) return false;
  Actor& actor = *actors_[turn.who];
  assert(actor.next() >= turn.time && "an actor has an earlier event and has not reported it");
  Time next = turn.time;
  {
    const Acting acting{*this, actor};
    others_ = length == Length::until_another ? calendar_.earliest_of_others(turn.who) : Time{0};
    do {
      now_ = next;
      actor.act(now_);
      next = actor.next();
    } while (length == Length::until_another && next < limit && next < others_);
  }
  calendar_.set_after_turn(turn.who, next);
  return true;
}

bool Scheduler::step(Time limit) {
  limit_ = limit;
  return turn(limit, Length::one_event);
}

void Scheduler::run_until(Time limit) {
  limit_ = limit;
  if (shuffle_.active()) {
    do run_some_ahead(limit);
    while (turn(limit, Length::one_event));
  } else {
    while (turn(limit, Length::until_another)) continue;
  }
}

}  // namespace machine
