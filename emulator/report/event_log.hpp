#pragma once
// The ordered events of a run: hashed as they come, and handed to whoever listens.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "report/event.hpp"

namespace state {
class Visitor;
}

namespace report {

/// Receives events in their final order. Must not change the run.
class EventSink {
 public:
  virtual ~EventSink() = default;
  virtual void event(const Event& event) = 0;
};

/// Puts events in order of (time, component, order of arrival) and hashes them (SHA-256, docs/trace.md).
///
/// Chips run ahead of one another, so events arrive out of order. `settle(t)` promises that nothing before `t` will
/// follow; what is settled is sorted and hashed, so the hash cannot depend on whose turn came first. Events of one
/// component must arrive in their own order.
class EventLog {
 public:
  EventLog();
  ~EventLog();
  EventLog(EventLog&&) noexcept;
  EventLog& operator=(EventLog&&) noexcept;

  /// Adds an event. \throws std::logic_error when its time lies before the last `settle`.
  void add(const Event& event);
  /// No event before `time` will follow. Cheap; call as often as is convenient.
  void settle(Time time);
  /// Hashes bytes of the final machine state after all events (calls `flush`).
  void absorb(std::span<const std::byte> bytes);
  /// The same, and sinks hear at once what is settled.
  void deliver(Time time);
  /// Settles everything that was added.
  void flush();
  /// SHA-256 of all that was settled so far, as 64 hexadecimal digits. May be asked at any time.
  std::string hash() const;
  /// The hash as it would be after flush and absorb(bytes), without doing either.
  std::string hash_with(std::span<const std::byte> bytes) const;
  /// Number of events added so far.
  std::uint64_t count() const { return count_; }
  /// `sink` hears every event settled from now on; it must outlive the log. Changes nothing in the hash.
  void listen(EventSink& sink);
  /// `sink` hears every event as it is added, in no order; null: nobody. Changes nothing.
  void tap(EventSink* sink) { tap_ = sink; }
  /// Settles first what may be settled, so that the state does not depend on when that was done last: sinks have then
  /// heard every event before the last `settle`, and those of a log that is loaded hear the rest.
  void list_state(state::Visitor& list);

 private:
  void drain(Time until);

  struct Digest;
  std::unique_ptr<Digest> digest_;
  std::vector<Event> pending_;
  std::vector<EventSink*> sinks_;
  EventSink* tap_ = nullptr;
  Time settled_ = Time::min();
  std::uint64_t count_ = 0;
  std::size_t drain_at_ = 4096;
};

}  // namespace report
