#pragma once
// The ordered events of a run: hashed in order and passed on to the sinks.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "report/events/event.hpp"

namespace state {
class Visitor;
}

namespace report {

/// Receives events in their final order. Must not change the run.
class EventSink {
 public:
  virtual ~EventSink() = default;
  virtual void event(const Event& event) = 0;
  /// Called while an exception of event() is handled; no event follows. Unless overridden, the exception ends the run.
  virtual void failed() { throw; }
};

/// Puts events in order of (time, component, order of arrival) and hashes them (SHA-256, docs/trace.md).
///
/// Chips run ahead of one another, so events arrive out of order. `settle(t)` promises that no event before `t` will
/// follow. Settled events are sorted and hashed, so the hash cannot depend on which chip ran first. Events of one
/// component must arrive in the component's own order.
class EventLog {
 public:
  EventLog();
  ~EventLog();
  EventLog(EventLog&&) noexcept;
  EventLog& operator=(EventLog&&) noexcept;

  /// Adds an event. \throws std::logic_error if its time lies before the last `settle`.
  /// Inlined, so that an event is made where it is kept: each bus transaction adds one.
  [[gnu::always_inline]] void add(const Event& event) {
    if (event.time < settled_ || waiting_ == pending_.size()) [[unlikely]] {
      const Event copy = event;  // so that nothing asks for the address of `event` itself
      return add_with_room(copy);
    }
    Event& added = pending_[waiting_++];
    added = event;
    ++count_;
    if (tap_ != nullptr) [[unlikely]]
      tap_->event(added);
  }
  /// Nobody will ask for an event or the hash: events that are added from now on are only checked.
  void discard();
  bool discards() const { return discards_; }
  /// No event before `time` will follow. Cheap; may be called often.
  void settle(Time time);
  /// As `settle`; sinks get the settled events at once.
  void deliver(Time time);
  /// Settles all events.
  void flush();
  /// SHA-256 of all settled events so far, as 64 hexadecimal digits. May be called at any time.
  std::string hash() const;
  /// The hash of all events so far, the unsettled ones too, and of bytes of the final machine state after them. Changes
  /// nothing.
  std::string hash_with(std::span<const std::byte> bytes) const;
  /// Number of events added so far.
  std::uint64_t count() const { return count_; }
  /// `sink` gets every event settled from now on; it must outlive the log. Does not change the hash.
  void listen(EventSink& sink);
  /// `sink` gets every event when it is added, in no order; null removes the sink. Changes nothing.
  void tap(EventSink* sink) { tap_ = sink; }
  /// Settles first what can be settled, so that the state does not depend on when this was last done. Sinks have then
  /// got every event before the last `settle`; the sinks of a loaded log get the rest.
  void list_state(state::Visitor& list);

 private:
  void add_with_room(const Event& event);
  void drain(Time until);
  std::span<Event> waiting() { return std::span(pending_).first(waiting_); }

  struct Digest;
  std::unique_ptr<Digest> digest_;
  std::vector<Event> pending_;  // with room behind the events that wait
  std::size_t waiting_ = 0;
  bool discards_ = false;
  std::vector<EventSink*> sinks_;
  EventSink* tap_ = nullptr;
  Time settled_ = Time::min();
  std::uint64_t count_ = 0;
  std::size_t drain_at_ = 4096;
};

}  // namespace report
