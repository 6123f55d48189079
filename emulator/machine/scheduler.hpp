#pragma once
/// The order in which things happen, of the dock and of networks: always the earliest event of all actors. Of several
/// at one instant, the actor that was added first.
///
/// Processors run ahead of that order on what is their own, up to their horizon: the earliest instant at which another
/// actor could act on them. So the order in which processors are advanced changes nothing, nor does the way in which
/// a run is cut; a seed shuffles the one, and tests compare.
///
/// When an actor's next event becomes another one, the actor says so: nobody is asked over and over.
#include <cstdint>
#include <vector>

#include "machine/event_calendar.hpp"
#include "machine/time.hpp"

namespace machine {

class Scheduler {
 public:
  class Actor {
   public:
    Actor() = default;
    Actor(const Actor&) = delete;
    Actor& operator=(const Actor&) = delete;
    virtual ~Actor() = default;
    /// Its next event, unless another actor changes that; never: it waits for others.
    virtual Time next() const = 0;
    /// Its event at `now` happens. Afterwards the scheduler asks for next() by itself.
    virtual void act(Time now) = 0;
    /// next() may have become another one: to be called wherever others make that happen. Of one that has become later
    /// it may be left out, if act() then finds nothing to do (the plant, which a reader may bring to its latch before
    /// its turn).
    void changed() {
      if (scheduler_ != nullptr && scheduler_->acting_ != this) scheduler_->calendar_.set(place_, next());
    }

   protected:
    /// next(), as it was when last told.
    Time planned() const { return scheduler_->calendar_.time(place_); }

   private:
    friend class Scheduler;
    Scheduler* scheduler_ = nullptr;
    std::size_t place_ = 0;
  };

  /// A chip, in its surroundings.
  class Processor : public Actor {
   public:
    /// It executes instructions, and its next event is the next of them.
    virtual bool runs() const = 0;
    /// \param until at most its horizon
    virtual void run_ahead(Time until) = 0;
    /// The earliest instant at which something outside could act on it, as far as this is known without asking others.
    virtual Time horizon() const = 0;
  };

  /// \param seed of the order in which processors are run ahead; 0: each when its turn comes
  explicit Scheduler(std::uint64_t seed = 0) : shuffle_{seed} {}
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  /// In the order of ties. The actor must outlive all runs.
  void add(Actor& actor);
  void add(Processor& processor);
  /// All events may have changed: what the actors stand for has been loaded.
  void all_changed();

  /// Lets the next event before `limit` happen; false: there is none.
  bool step(Time limit);
  /// Lets some processors do in advance what is theirs alone, as far as the seed says; nothing without one.
  void run_some_ahead(Time limit);
  /// Lets all events before `limit` happen.
  void run_until(Time limit);
  /// Where the run under way ends.
  Time limit() const { return limit_; }
  /// Of the last event.
  Time now() const { return now_; }
  Time earliest() const { return calendar_.earliest().time; }
  Time earliest_of_others(const Actor& than) const { return calendar_.earliest_of_others(than.place_); }
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

  /// While an actor acts, its own next event is not entered over and over.
  struct Acting {
    Acting(Scheduler& its_scheduler, const Actor& actor) : scheduler{its_scheduler} { scheduler.acting_ = &actor; }
    ~Acting() { scheduler.acting_ = nullptr; }
    Acting(const Acting&) = delete;
    Acting& operator=(const Acting&) = delete;
    Scheduler& scheduler;
  };

  EventCalendar calendar_;
  std::vector<Actor*> actors_;
  std::vector<Processor*> processors_;
  Time limit_{0};
  Time now_{0};
  const Actor* acting_ = nullptr;
  Shuffle shuffle_;
};

}  // namespace machine
