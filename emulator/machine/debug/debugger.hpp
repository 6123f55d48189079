#pragma once
/// The debugger, for every front end: stop conditions, steps, and time backwards.
///
/// A stop is one instant for the whole machine: everything before it has happened on all chips. Conditions are armed
/// while the machine runs, and noted when they are met. The earliest one counts: the machine is brought there, by a
/// snapshot and the run from it where chips were ahead. So looking changes nothing, and going back is the same thing as
/// going on.
///
/// A breakpoint stops before its instruction, a watchpoint after the access. What happens at the instant of a stop on
/// other chips, too, is told with it. Going on looks at what is later.
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "c40/probe.hpp"
#include "machine/debug/debuggee.hpp"
#include "machine/debug/error.hpp"
#include "machine/debug/history.hpp"
#include "machine/debug/inspect.hpp"

namespace machine::debug {

/// What to stop at.
struct Trigger {
  enum class Kind : std::uint8_t {
    code,                ///< before the instruction at `address`
    word,                ///< an access to one of `words` words from `address` on
    processor_register,  ///< `name` has changed: the chip runs by single instructions
    happening,           ///< of kind `name`, with `fields`
    value,               ///< the expression `name` has become true: looked at every Debuggee::value_period()
  };
  enum class On : std::uint8_t { write, read, access, change };

  Kind kind = Kind::code;
  std::optional<std::size_t> chip{};  ///< none: every one (of happenings: any)
  Address address = 0;
  Word words = 1;
  On on = On::write;
  std::string name{};
  std::map<std::string, std::string, std::less<>> fields{};
  std::string condition{};   ///< an expression; empty: always
  std::string log{};         ///< not empty: tell this text, with {expressions}, and go on
  std::uint64_t ignore = 0;  ///< hits to pass over
  bool enabled = true;
  bool once = false;   ///< removed when it has stopped the machine
  std::string text{};  ///< as the user said it

  /// It stops at the same, whatever has been counted.
  bool same_as(const Trigger& other) const {
    return kind == other.kind && chip == other.chip && address == other.address && words == other.words &&
           on == other.on && name == other.name && fields == other.fields && condition == other.condition &&
           log == other.log && enabled == other.enabled;
  }

  /// The name of a happening that an instruction causes by breaking a rule of the manual.
  static constexpr std::string_view rules = "rule";
  bool of_rules() const { return kind == Kind::happening && name == rules; }
  /// Its chip runs by single instructions.
  bool by_instructions() const { return kind == Kind::processor_register || of_rules(); }

  std::uint64_t hits = 0;  ///< on the way forward, those passed over among them
};

struct Hit {
  unsigned trigger = 0;  ///< its number
  Time time{};
  std::optional<std::size_t> chip{};
  std::string text{};          ///< what happened: "DSP 1 wrote 0000002Ah (was 0) to 80000010h at kernel_pid+0x4"
  Address pc = 0;              ///< of the instruction, where one did it
  Word before = 0, value = 0;  ///< of an access
  bool open = false;           ///< whether its condition holds is looked at where the machine stands there
};

struct Stop {
  enum class Reason : std::uint8_t { start, breakpoint, watchpoint, happening, step, moved, paused, over, fault };
  Reason reason = Reason::start;
  Time time{};
  std::optional<std::size_t> chip;  ///< which to show
  std::vector<Hit> hits;            ///< all at this instant
  std::string text;                 ///< one sentence
};
std::string_view name(Stop::Reason reason);

enum class Step : std::uint8_t {
  instruction,
  over,       ///< a call and all it does is one step
  line,       ///< to another source line, into calls
  next_line,  ///< to another source line, calls counted as one
  out,        ///< to behind the call of the routine that runs
  claim,      ///< to the chip's next claim of a task block
  refresh,    ///< to the host's next refresh of the list
  happening,  ///< the next one of any kind
};

/// Who wrote a word.
struct Writer {
  Time time{};  ///< afterwards
  std::optional<std::size_t> chip;
  Address pc = 0;
  Word before = 0, value = 0;
  std::string text;
};

class Debugger {
 public:
  explicit Debugger(Debuggee& debuggee, HistoryLimits limits = {});
  /// Takes all that listens away. The machine stays where it is.
  ~Debugger();
  Debugger(const Debugger&) = delete;
  Debugger& operator=(const Debugger&) = delete;

  Debuggee& debuggee() { return debuggee_; }
  Time now() const { return debuggee_.now(); }
  const ProgramView& program(std::size_t chip) const { return programs_.at(chip); }
  const std::vector<ProgramView>& programs() const { return programs_; }
  const Stop& stop() const { return stop_; }
  /// Kinds of happenings that it can stop at, with what they are.
  std::vector<std::pair<std::string, std::string>> happenings() const;

  // ---- what to stop at ----
  /// The number of the new one. \throws DebugError for what cannot be: an address without memory, a condition that does
  /// not parse
  unsigned add(Trigger trigger);
  /// \throws DebugError
  void remove(unsigned number);
  void enable(unsigned number, bool on);
  const std::map<unsigned, Trigger>& triggers() const { return triggers_; }
  /// Chips that armed triggers let run by single instructions: slow.
  std::vector<std::size_t> stepped_chips() const;

  // ---- forward ----
  /// To the next hit after now, or `until`. Paused by interrupt() and io::stop_asked().
  const Stop& go(Time until = never);
  const Stop& step(std::size_t chip, Step step);

  // ---- backward ----
  /// To the last hit before now; where there is none, to the beginning.
  const Stop& go_back(Time until = Time{0});
  /// instruction: before the instruction that ended last; over, line, out: as their names say, backwards.
  const Stop& step_back(std::size_t chip, Step step);
  /// To any instant from the beginning on; later ones are run to, stop conditions not looked at.
  const Stop& go_to(Time time);
  /// The last write to a word before now; none: it was not written since the beginning. The machine stays where it is.
  std::optional<Writer> last_write(std::size_t chip, Address address);
  /// What each instruction cost when it ran last, of those of the last 200 us.
  std::map<Address, c40::Causes> recent_costs(std::size_t chip);
  Time beginning() const;
  HistoryInfo history() const;

  // ---- changes by hand: what was later is gone, and a new branch begins ----
  /// \throws DebugError
  void set_word(std::size_t chip, Address address, Word value);
  /// By the name of a register ("AR0", "R1" with 40 bits or a float). \throws DebugError
  void set_register(std::size_t chip, std::string_view name, std::string_view expression);
  /// How many changes this branch has had.
  std::size_t changes() const;

  /// From another thread or a signal: the command under way ends soon.
  void interrupt() { interrupted_ = true; }

  /// Texts of log points, and of new branches.
  std::function<void(const std::string&)> output;
  /// Called now and then during long work: how far from `from` to `to`.
  std::function<void(Time at, Time from, Time to)> progress;

 private:
  class HitRecorder;
  /// A change by hand, made again whenever its instant is passed.
  struct Change {
    Time time{};
    std::function<void()> make;
  };
  struct Manner;

  bool asked_to_stop();
  void require_chip(std::size_t chip) const;
  void check(const Trigger& trigger);
  const Stop& stopped(Stop::Reason reason, std::optional<std::size_t> chip, std::string text,
                      std::vector<Hit> hits = {});
  const Stop& report(std::vector<Hit> hits);
  void run_to(Time time);
  void move_to(Time time);
  void move_and_listen(Time time, const Manner& manner);
  void hear_what_is_under_way(const Manner& manner);
  void load_before(Time time);
  std::vector<Hit> search(Time until, const Manner& manner);
  std::vector<Hit> last_hits(Time after, Time before);
  bool counts(const Hit& hit);
  bool holds(const Hit& hit);
  const Stop& go_on(Time until, const Manner& manner);
  const Stop& step_lines(std::size_t chip, bool over_calls);
  const Stop& step_over(std::size_t chip);
  const Stop& run_to_code(std::size_t chip, Address address, std::string condition);
  Trigger happening_of(std::size_t chip, Step step);
  template <class Fits>
  std::optional<Time> instruction_before(std::size_t chip, Time time, Fits fits);
  void look_at_past(std::size_t chip, Time from, Time to);
  void change(std::function<void()> make, std::string text);

  Debuggee& debuggee_;
  std::vector<ProgramView> programs_;
  std::map<unsigned, Trigger> triggers_;
  unsigned next_number_ = 1;
  std::unique_ptr<HitRecorder> recorder_;
  /// Where the machine stands with the ear having heard what ends later: instructions are done as a whole, and what
  /// they do may be after a stop.
  std::optional<Time> heard_at_;
  std::map<unsigned, Trigger> heard_for_;  ///< the triggers that were armed then
  std::unique_ptr<History> history_;
  std::vector<Change> changes_;
  std::size_t changed_ = 0;  ///< of the changes, those that have been made where the machine stands
  /// Instructions of a chip, where one goes back step by step.
  struct Past {
    struct Instruction {
      Time begins{};
      Address pc = 0, sp = 0;  ///< SP before it
      c40::Causes causes{};
    };
    std::size_t chip = 0;
    Time from{}, to{};
    std::vector<Instruction> instructions{};
  };
  std::optional<Past> past_;
  Stop stop_;
  std::atomic<bool> interrupted_{false};
};

}  // namespace machine::debug
