#pragma once
/// The debugger, for every front end: stop conditions, steps, and time backwards.
///
/// A stop is one instant for the whole machine: everything before it has happened on all chips. Conditions are checked
/// while the machine runs, and hits are recorded. The earliest hit counts: if chips were ahead, the machine is brought
/// to this instant by a snapshot and a run from the snapshot. So looking changes nothing, and going back works like
/// going forward.
///
/// A breakpoint stops before its instruction, a watchpoint after the access. Hits of other chips at the same instant
/// are reported together. A search continues with later instants.
#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "c40/observers/probe.hpp"
#include "machine/debug/debuggee.hpp"
#include "machine/debug/error.hpp"
#include "machine/debug/history.hpp"
#include "machine/debug/inspect.hpp"

namespace machine::debug {

/// A stop condition.
struct Trigger {
  enum class Kind : std::uint8_t {
    code,                ///< before the instruction at any of `places`
    word,                ///< an access to one of `words` words from `address` on
    processor_register,  ///< `name` has changed: the chip runs by single instructions
    event,               ///< an event of kind `name`, with `fields`
    value,               ///< the expression `name` has become true; checked every Debuggee::value_period()
  };
  enum class On : std::uint8_t { write, read, access, change };

  Kind kind = Kind::code;
  std::optional<std::size_t> chip{};  ///< none: all chips (for events: any)
  std::vector<CodePlace> places{};
  Address address = 0;
  Word words = 1;
  On on = On::write;
  std::string name{};
  /// Of an event. A number may have any form that a user can write.
  std::map<std::string, std::string, std::less<>> fields{};
  std::string condition{};   ///< an expression; empty: always
  std::string log{};         ///< not empty: print this text, with {expressions}, and continue
  std::uint64_t ignore = 0;  ///< number of hits to ignore
  bool enabled = true;
  std::string text{};  ///< in the user's words

  /// Whether both stop at the same hits, without regard to counts.
  bool same_as(const Trigger& other) const {
    return kind == other.kind && chip == other.chip && places == other.places && address == other.address &&
           words == other.words && on == other.on && name == other.name && fields == other.fields &&
           condition == other.condition && log == other.log && enabled == other.enabled;
  }

  /// It stops the chip before the instruction at `pc`.
  bool stops(std::size_t n, Address pc) const {
    return kind == Kind::code && chip.value_or(n) == n && std::ranges::any_of(places, [&](const CodePlace& place) {
             return place.chip.value_or(n) == n && place.address == pc;
           });
  }

  /// The name of the event "an instruction breaks a rule of the manual".
  static constexpr std::string_view rules = "rule";
  bool of_rules() const { return kind == Kind::event && name == rules; }
  /// The trigger's chip runs instruction by instruction.
  bool by_instructions() const { return kind == Kind::processor_register || of_rules(); }

  std::uint64_t hits = 0;  ///< going forward, including ignored ones
};

struct Hit {
  unsigned trigger = 0;  ///< the trigger's number
  Time time{};
  std::optional<std::size_t> chip{};
  std::string text{};          ///< what happened: "DSP 1 wrote 0000002Ah (was 0) to 80000010h at kernel_pid+0x4"
  Address pc = 0;              ///< of the instruction, if one did it
  Word before = 0, value = 0;  ///< of an access
  bool open = false;           ///< its condition is still to be checked, when the machine is at this instant
};

struct Stop {
  enum class Reason : std::uint8_t {
    start,
    breakpoint,
    watchpoint,
    event,
    step,
    moved,
    paused,
    over,
    fault,
    software_interrupt,  ///< before SWI, which calls the debugger
  };
  Reason reason = Reason::start;
  Time time{};
  std::optional<std::size_t> chip;  ///< the chip to show
  std::vector<Hit> hits;            ///< all hits at this instant
  std::string text;                 ///< one sentence
};
std::string_view name(Stop::Reason reason);

enum class Step : std::uint8_t {
  instruction,
  over,       ///< a call with everything that it does is one step
  line,       ///< to another source line, into calls
  next_line,  ///< to another source line, calls counted as one
  out,        ///< to the instruction after the call of the present routine
  claim,      ///< to the chip's next claim of a task block
  refresh,    ///< to the host's next refresh of the list
  event,      ///< the next one of any kind
};

/// The instruction or device that wrote a word.
struct Writer {
  Time time{};  ///< after the write
  std::optional<std::size_t> chip;
  Address pc = 0;
  Word before = 0, value = 0;
  std::string text;
};

class Debugger {
 public:
  explicit Debugger(Debuggee& debuggee, HistoryLimits limits = {});
  /// Removes all listeners. The machine stays at its instant.
  ~Debugger();
  Debugger(const Debugger&) = delete;
  Debugger& operator=(const Debugger&) = delete;

  Debuggee& debuggee() { return debuggee_; }
  Time now() const { return debuggee_.now(); }
  const ProgramView& program(std::size_t chip) const { return programs_.at(chip); }
  const std::vector<ProgramView>& programs() const { return programs_; }
  const Stop& stop() const { return stop_; }
  /// Kinds of events at which it can stop.
  std::vector<EventKind> event_kinds() const;

  // ---- stop conditions ----
  /// Returns the number of the new condition. \throws DebugError for an impossible one: an address without memory, a
  /// condition that does not parse
  unsigned add(Trigger trigger);
  /// What a user means by a name to watch: a register, else a word; of a trigger, its kind, chip, and register or
  /// address. \throws DebugError for a register that cannot be watched, and for what is no place
  Trigger watched(std::size_t chip, std::string_view name) const;
  /// \throws DebugError
  void remove(unsigned number);
  void enable(unsigned number, bool on);
  const std::map<unsigned, Trigger>& triggers() const { return triggers_; }

  // ---- forward ----
  /// To the next hit after now, or to `until`. interrupt() and io::stop_asked() pause it.
  const Stop& go(Time until = never);
  const Stop& step(std::size_t chip, Step step);

  // ---- backward ----
  /// To the last hit before now; if there is none, to the beginning.
  const Stop& go_back(Time until = Time{0});
  /// instruction: before the instruction executed last; over, line, out: like the forward steps, backwards.
  const Stop& step_back(std::size_t chip, Step step);
  /// To any instant since the beginning; to a later one without checking stop conditions.
  const Stop& go_to(Time time);
  /// The last write to a word before now; none: no write since the beginning. The machine stays at its instant.
  std::optional<Writer> last_write(std::size_t chip, Address address);
  /// The cost of each instruction's last execution, for the instructions of the last 200 us.
  std::map<Address, c40::Causes> recent_costs(std::size_t chip);
  Time beginning() const;
  HistoryInfo history() const;

  // ---- changes by hand: everything later is discarded, and a new branch begins ----
  /// \throws DebugError
  void set_word(std::size_t chip, Address address, Word value);
  /// By the name of a register: an integer of 32 bits; of R0 to R11 also a float. A PC that is set takes the
  /// instruction under way away. \throws DebugError
  void set_register(std::size_t chip, std::string_view name, std::string_view expression);
  /// Number of changes in this branch.
  std::size_t changes() const;

  /// From another thread or a signal: ends the present command soon.
  void interrupt() { interrupted_ = true; }

  /// Called with the texts of log points, and of new branches.
  std::function<void(const std::string&)> output;
  /// Called from time to time during long work: the present instant between `from` and `to`.
  std::function<void(Time at, Time from, Time to)> progress;

 private:
  class HitRecorder;
  /// Where a chip is, or was.
  struct Place {
    std::size_t chip = 0;
    Time time{};
    Address pc = 0, sp = 0;
  };
  /// What a chip did: an instruction, or the entry of an interrupt; `pc` is then where it returns to.
  struct Instruction {
    Time begins{}, ends{};
    Address pc = 0, sp = 0;  ///< SP before it
    c40::Causes causes{};
    bool interrupt = false;
  };
  /// A change by hand, repeated whenever its instant is passed.
  struct Change {
    Time time{};
    std::function<void()> make;
  };
  struct Manner;
  class Temporary;
  class Only;

  bool asked_to_stop();
  void require_chip(std::size_t chip) const;
  void check(const Trigger& trigger);
  Trigger as_events_tell(Trigger trigger) const;
  const Stop& paused();  ///< at this instant
  const Stop& stopped(Stop::Reason reason, std::optional<std::size_t> chip, std::string text,
                      std::vector<Hit> hits = {});
  const Stop& report(std::vector<Hit> hits);
  const Stop& ended();
  void run_to(Time time);
  void move_to(Time time);
  void move_and_listen(Time time, const Manner& manner);
  void hear_what_is_under_way(const Manner& manner);
  void load_before(Time time);
  std::vector<Hit> search(Time until, const Manner& manner);
  std::vector<Hit> last_hits(Time after, Time before);
  bool counts(const Hit& hit);
  bool holds(const Hit& hit);
  const Stop& resume(Time until, const Manner& manner);
  const Stop& step_lines(std::size_t chip, bool over_calls);
  const Stop& step_over(std::size_t chip);
  const Stop& run_to_code(std::size_t chip, Address address, std::string condition);
  Trigger event_of(std::size_t chip, Step step);
  template <class Fits>
  std::optional<Time> instruction_before(std::size_t chip, Time time, Fits fits);
  std::optional<Place> before(const Place& place);
  std::optional<Place> before_over(const Place& place);
  std::optional<Time> line_before(const Place& place, bool over_calls);
  const std::vector<Instruction>& past_of(std::size_t chip, Time time, Time window);
  void look_at_past(std::size_t chip, Time from, Time to);
  void change(std::function<void()> by_hand, std::string text, std::optional<std::size_t> moved = {});

  Debuggee& debuggee_;
  std::vector<ProgramView> programs_;
  std::map<unsigned, Trigger> triggers_;
  unsigned next_number_ = 1;
  std::unique_ptr<HitRecorder> recorder_;
  /// The machine is at this instant, and the recorder has heard what ends later: instructions are executed whole, and
  /// their effects may be after a stop.
  std::optional<Time> heard_at_;
  std::map<unsigned, Trigger> heard_for_;  ///< the triggers of that time
  std::unique_ptr<History> history_;
  std::vector<Change> changes_;
  std::size_t changed_ = 0;  ///< number of the changes that have been made at the machine's instant
  /// Instructions of a chip, for steps backwards.
  struct Past {
    std::size_t chip = 0;
    Time from{}, to{};
    std::vector<Instruction> instructions{};  ///< by time
  };
  std::optional<Past> past_;
  Stop stop_;
  std::atomic<bool> interrupted_{false};
};

}  // namespace machine::debug
