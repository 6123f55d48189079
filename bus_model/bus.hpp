#pragma once
// One PCI bus (2.1, 32 bit), transaction by transaction (plant-and-bus.md 3.1, 3.6). Time is a count of bus clocks.
//
// A transaction of n words occupies 1 + F + (n - 1)(1 + W_s) + 1 clocks: the address phase, F = devsel + W_i for a
// write or max(devsel, 2) + W_i for a read up to and with the first data phase, the further data phases, one
// turnaround. Arbitration is hidden behind the running transaction. On an idle bus a master starts grant_clocks after
// its request, or at once if the grant is parked on this master. The target cuts a transaction by disconnect or retry;
// the latency timer cuts it once another master requests the bus. The bus repeats the rest by itself. A stopped master
// drops REQ# for request_off_after_stop clocks. The command matters in two places: for what a target fetches ahead for
// a delayed read, and for the latency timer, which lets Memory Write and Invalidate continue to the end of a cache
// line.
//
// Inaccuracies: masters are always ready (no IRDY# waits). The words of a write reach the target together at the end of
// the attempt. A single word is read at its data phase; the words of a burst read are fetched at FRAME# with the clocks
// of their data phases, so windows whose reads have effects need max_burst 1. No parity, no LOCK#, no I/O or
// configuration cycles.
#include <cstdint>
#include <span>
#include <vector>

#include "bus_model/arbiter.hpp"
#include "bus_model/config.hpp"
#include "bus_model/statistics.hpp"

namespace pci {

enum class Result : std::uint8_t {
  done,
  master_abort,  ///< no target claimed the address; reads give all ones
  target_abort,  ///< the target refused the access for good
  withdrawn,     ///< the master left the bus
};

/// A transaction as its master sees it, over all its attempts.
struct Transaction {
  std::uint64_t number = 0;  ///< on this bus, in the order of the first FRAME#
  Address address = 0;
  unsigned words = 0;  ///< wanted; after the end: transferred
  std::uint16_t master = 0;
  std::int16_t target = -1;  ///< index of the window that answered
  bool write = false;
  Command command = Command::read;
  std::uint16_t agent = 0;
  Result result = Result::done;
  Clocks requested = 0;
  Clocks granted = 0;     ///< GNT# of the first attempt
  Clocks framed = 0;      ///< FRAME# of the first attempt
  Clocks first_data = 0;  ///< clock of the first data phase
  Clocks ended = 0;       ///< the clock after the last data phase
  Clocks waited = 0;      ///< from REQ# to FRAME#, over all attempts
  std::uint32_t retries = 0;
  std::uint32_t disconnects = 0;
};

/// One attempt on the bus, from FRAME# to the last data phase (or stop).
struct Attempt {
  enum class Kind : std::uint8_t { data, retry, master_abort, target_abort };
  std::uint16_t master = 0;
  std::int16_t target = -1;
  Kind kind = Kind::data;
  bool write = false;
  Command command = Command::read;
  Address address = 0;
  unsigned wanted = 0;  ///< words left to do
  unsigned words = 0;   ///< data phases in this attempt
  Clocks requested = 0;
  Clocks frame = 0;
  Clocks first = 0;  ///< first data phase
  Clocks step = 1;   ///< from one data phase to the next
  Clocks last = 0;   ///< last data phase, or clock of the stop
};

/// An access, as its target sees it.
struct Access {
  unsigned master;  ///< the master that drives the bus
  Clocks clock;
  unsigned agent =
      0;  ///< the agent that wants the access: MasterConfig::agent, or the agent of another bus for which a bridge acts
  Command command = Command::read;
};

enum class Answer : std::uint8_t { accept, retry, abort };

/// A device behind one or several windows. Offsets count from the window's base.
class Target {
 public:
  virtual ~Target() = default;
  /// It accepts each access whole: neither answer() nor most() is called.
  virtual bool takes_all() const { return false; }
  /// Called at FRAME# of each attempt.
  virtual Answer answer(Address /*offset*/, unsigned /*words*/, bool /*write*/, const Access&) {
    return Answer::accept;
  }
  /// For an access that the target accepts: after how many words the target disconnects.
  virtual unsigned most(Address /*offset*/, unsigned words, bool /*write*/, const Access&) { return words; }
  virtual Word read(Address offset, const Access& access) = 0;
  /// A burst read: words[i] at clock access.clock + i * step.
  virtual void read_burst(Address offset, std::span<Word> words, Access access, Clocks step) {
    for (Word& word : words) {
      word = read(offset++, access);
      access.clock += step;
    }
  }
  virtual void write(Address offset, Word value, const Access& access) = 0;
};

/// A target's window, for accesses without transactions.
class DirectWindow {
 public:
  DirectWindow() = default;
  DirectWindow(Target& target, Address base, std::uint64_t words)
      : target_{&target}, base_{base}, words_{words}, takes_all_{target.takes_all()} {}
  bool holds(Address address) const { return address - base_ < words_; }
  /// One word, with no clocks, no arbitration and no counts. `value` is written, or gets the word read. False: the
  /// target does not take the access now, and nothing has happened.
  bool access(Address address, bool write, Word& value, const Access& access) const {
    const Address offset = address - base_;
    if (!takes_all_ && target_->answer(offset, 1, write, access) != Answer::accept) return false;
    if (write)
      target_->write(offset, value, access);
    else
      value = target_->read(offset, access);
    return true;
  }

 private:
  Target* target_ = nullptr;
  Address base_ = 0;
  std::uint64_t words_ = 0;
  bool takes_all_ = false;
};

/// A master's own logic. Calls come from Bus::step, in bus order.
class Initiator {
 public:
  virtual ~Initiator() = default;
  /// FRAME# of an attempt, decided at clock `now` <= attempt.frame. `first`: the first attempt of this transaction. A
  /// write may then put more words into `room` (the submitted words are its first attempt.wanted) and return the new
  /// number.
  virtual unsigned framed(const Attempt& attempt, bool first, Clocks now, std::span<Word> room) = 0;
  /// The words of a burst read, known ahead: word i arrives with the data phase at first + i * step.
  virtual void arriving(const Attempt& /*attempt*/, std::span<const Word> /*words*/) {}
  /// The transaction has ended. The transaction and `words` (of a read) stay valid until this master submits again,
  /// which it may do from `transaction.ended` on.
  virtual void completed(const Transaction& transaction, std::span<const Word> words) = 0;
};

/// Sees everything on the bus and changes nothing.
class Monitor {
 public:
  virtual ~Monitor() = default;
  virtual void attempted(const Attempt&) {}
  virtual void ended(const Transaction&) = 0;
};

/// Called when the bus's next_event() may have changed.
class PlanListener {
 public:
  virtual ~PlanListener() = default;
  virtual void replanned() = 0;
};

class Bus {
 public:
  static constexpr unsigned most_words = 256;  ///< of one transaction
  static constexpr unsigned most_masters = 32;

  explicit Bus(BusConfig config = {});
  ~Bus();
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  /// Masters are numbered from 0 in order of addition. The initiator must outlive the bus. Throws std::invalid_argument
  /// for parameters that PCI forbids.
  unsigned add_master(const MasterConfig& config, Initiator& initiator);
  /// A window [base, base + words) of a target; windows must not overlap. Returns the window's index.
  unsigned add_target(const TargetConfig& config, Target& target, Address base, std::uint64_t words);

  /// Asserts REQ# at clock `request` >= now() for `words` words from `address` on. The caller puts the words of a write
  /// into buffer(master) before. `speculative`: a read that ends at the first stop after which it has at least one
  /// word. A master has one transaction at a time (std::logic_error otherwise).
  void submit(unsigned master, bool write, Address address, unsigned words, Clocks request, bool speculative = false);
  /// The same with a command that the master chooses, for an agent other than the master.
  void submit(unsigned master, Command command, Address address, unsigned words, Clocks request, unsigned agent);
  /// The default command of such a transaction: for a read by the cache lines that it touches; a plain write.
  Command command_of(bool write, Address address, unsigned words) const;
  std::span<Word> buffer(unsigned master);
  bool busy(unsigned master) const;
  /// The master leaves at clock `now`. Its request ends, its running transaction breaks off; words whose data phases
  /// have passed are moved. completed() is not called. Returns the number of words moved.
  unsigned withdraw(unsigned master, Clocks now);

  /// What answers at an address.
  DirectWindow window_at(Address address) const;

  /// From clock `now` on the arbiter grants nothing before clock `until`; a running attempt continues to its end.
  void stall(Clocks now, Clocks until);

  /// The clock of the next event of this bus, or never.
  Clocks next_event() const { return next_; }
  /// Executes the next event.
  void step() {
    now_ = next_;
    if (running_)
      finish();
    else
      start(chosen_, chosen_at_, now_);
  }
  /// Executes all events up to and with `clock`.
  void advance_to(Clocks clock);
  Clocks now() const { return now_; }

  /// \param attempts whether it wants to see attempts
  void set_monitor(Monitor* monitor, bool attempts = true) {
    monitor_ = monitor;
    attempt_monitor_ = attempts ? monitor : nullptr;
  }
  /// The listener is not called for the bus's own steps.
  void set_plan_listener(PlanListener* listener) { plan_listener_ = listener; }
  const BusConfig& config() const { return config_; }
  unsigned masters() const;
  unsigned targets() const;
  const MasterConfig& master_config(unsigned master) const;
  bool was_stalled() const { return was_stalled_; }
  /// The attempt that is on the bus, or begins next, as it will end; null: none.
  const Attempt* under_way() const { return running_ ? &attempt_ : nullptr; }
  /// Data phases of all attempts that have ended.
  std::uint64_t words_moved() const;
  const std::string& master_name(unsigned master) const;
  const std::string& target_name(unsigned target) const;
  /// Of clocks 0 to clock - 1, where `clock` is now() or later, but not later than next_event().
  BusStatistics statistics(Clocks clock) const;
  const MasterStatistics& master_statistics(unsigned master) const;
  const TargetStatistics& target_statistics(unsigned target) const;
  void list_state(state::Visitor& list);

 private:
  struct Port;
  struct Window;

  void submit(Port& port, unsigned master, Command command, Address address, unsigned words, Clocks request,
              unsigned agent, bool speculative);
  Port& port_of(unsigned master);
  void start(unsigned master, Clocks granted, Clocks frame);
  void choose_answer(Window& window, const Port& port);
  void cut_by_timer();
  void finish();
  void move_words(Port& port, unsigned words);
  void arbitrate(Clocks last);
  void plan_idle(Clocks requested);
  unsigned fetched_ahead(const TargetConfig& config) const;
  Access access_of(const Port& port, Clocks clock) const;
  void ask(unsigned master, Clocks request);
  void ask_no_more(unsigned master);
  Clocks earliest_request(unsigned except) const;
  unsigned winner(Clocks latest) const;
  int window_of(Address address, int last) const;
  void account(Clocks words, Clocks length);
  void count_idle(BusStatistics& statistics, Clocks clock) const;

  BusConfig config_;
  Arbiter arbiter_;
  std::vector<Port> ports_;
  std::vector<Clocks> requests_;  // by master: the clock from which REQ# is asserted, or never
  std::uint32_t asking_ = 0;      // bit n: master n's REQ# is asserted, or will be
  std::vector<Window> windows_;
  Attempt attempt_{};
  bool running_ = false;
  bool finishing_ = false;  // an attempt has ended, and the next master is not chosen yet
  bool ahead_ = false;      // the attempt's words have been read at FRAME#
  bool after_write_ = false;
  unsigned chosen_ = Arbiter::nobody;  // the master that starts at next_ on an idle bus
  Clocks chosen_at_ = 0;               // the clock at which this master gets GNT#
  unsigned natural_words_ = 0;
  bool ends_itself_ = false;  // natural_words_ is the master's own limit
  bool was_stalled_ = false;
  Clocks now_ = 0;
  Clocks free_ = 0;     // first clock after the last turnaround
  Clocks counted_ = 0;  // idle clocks before this one are in the statistics
  Clocks stalled_ = 0;  // no FRAME# before this clock
  Clocks next_ = never;
  std::uint64_t started_ = 0;
  BusStatistics statistics_;
  void tell_plan() {
    if (plan_listener_ != nullptr) plan_listener_->replanned();
  }

  Monitor* monitor_ = nullptr;
  Monitor* attempt_monitor_ = nullptr;
  PlanListener* plan_listener_ = nullptr;
};

}  // namespace pci
