#pragma once
/// The order of events, for the dock and for networks: always the earliest event of all actors. If several are at one
/// instant, the actor that was added first comes first.
///
/// Processors run ahead of that order as long as they use only their own resources, up to their horizon: the earliest
/// instant at which another actor could act on them. So neither the order in which processors advance nor the way in
/// which a run is divided changes anything. A seed shuffles the order, and tests compare.
///
/// When an actor's next event changes, the actor reports it; the scheduler does not ask all actors again and again.
#include <cstdint>
#include <vector>

#include "machine/time/event_calendar.hpp"
#include "machine/time/time.hpp"

namespace machine {

class Scheduler {
 public:
  class Actor {
   public:
    Actor() = default;
    Actor(const Actor&) = delete;
    Actor& operator=(const Actor&) = delete;
    virtual ~Actor() = default;
    /// Its next event, unless another actor changes it; never: it waits for others.
    virtual Time next() const = 0;
    /// Executes its event at `now`. Afterwards the scheduler calls next() by itself.
    virtual void act(Time now) = 0;
    /// next() may have changed: to be called wherever another actor changes it. If it only became later, the call may
    /// be left out, provided act() then finds nothing to do (the plant, which a reader may advance to its latch before
    /// its turn).
    void changed() {
      if (scheduler_ == nullptr || scheduler_->acting_ == this) return;
      if (const Time now = next(); now != planned()) scheduler_->enter(*this, now);
    }

   protected:
    /// next() as of the last report.
    Time planned() const { return scheduler_->calendar_.time(place_); }

   private:
    friend class Scheduler;
    Scheduler* scheduler_ = nullptr;
    std::size_t place_ = 0;
  };

  /// A chip with its surroundings.
  class Processor : public Actor {
   public:
    /// It executes instructions, and its next event is the next instruction.
    virtual bool runs() const = 0;
    /// \param until at most its horizon
    virtual void run_ahead(Time until) = 0;
    /// The earliest instant at which something outside could act on it, as far as known without asking others.
    virtual Time horizon() const = 0;
  };

  /// \param seed for the order in which processors run ahead; 0: each when its turn comes
  explicit Scheduler(std::uint64_t seed = 0) : shuffle_{seed} {}
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  /// In the order of ties. The actor must outlive all runs.
  void add(Actor& actor);
  void add(Processor& processor);
  /// All events may have changed: the actors' objects have been loaded.
  void all_changed();

  /// Executes the next event before `limit`; false: there is none.
  bool step(Time limit);
  /// Lets some processors run ahead, as the seed says; does nothing without a seed.
  void run_some_ahead(Time limit);
  /// Executes all events before `limit`.
  void run_until(Time limit);
  /// The end of the present run.
  Time limit() const { return limit_; }
  /// The instant of the last event.
  Time now() const { return now_; }
  /// While an actor acts: its event.
  Time earliest() const { return acting_ != nullptr ? now_ : calendar_.earliest().time; }
  Time earliest_of_others(const Actor& than) const { return calendar_.earliest_of_others(than.place_); }
  /// `actor` acts, and as far as known without a search, the others have no event up to and with `time`.
  bool is_first_until(Time time, const Actor& actor) const { return acting_ == &actor && time < others_; }
  bool shuffles() const { return shuffle_.active(); }

 private:
  /// xorshift64*
  class Shuffle {
   public:
    explicit Shuffle(std::uint64_t seed) : state_{seed} {}
    bool active() const { return state_ != 0; }
    std::uint64_t below(std::uint64_t bound) {
      state_ ^= state_ >> 12, state_ ^= state_ << 25, state_ ^= state_ >> 27;
      return (state_ * 0x2545F4914F6CDD1Du >> 11) % bound;
    }

   private:
    std::uint64_t state_;
  };

  void enter(const Actor& actor, Time next);

  /// While an actor acts, its own next event is entered only once, at the end.
  struct Acting {
    Acting(Scheduler& its_scheduler, const Actor& actor) : scheduler{its_scheduler} { scheduler.acting_ = &actor; }
    ~Acting() { scheduler.acting_ = nullptr; }
    Acting(const Acting&) = delete;
    Acting& operator=(const Acting&) = delete;
    Scheduler& scheduler;
  };

  /// How many events of an actor are executed in a row: the calendar changes only afterwards.
  enum class Length : std::uint8_t { one_event, until_another };
  bool turn(Time limit, Length length);

  EventCalendar calendar_;
  std::vector<Actor*> actors_;
  std::vector<Processor*> processors_;
  Time limit_{0};
  Time now_{0};
  const Actor* acting_ = nullptr;
  Time others_{0};  ///< while an actor has its events in a row: no other actor has an earlier event
  Shuffle shuffle_;
};

}  // namespace machine
