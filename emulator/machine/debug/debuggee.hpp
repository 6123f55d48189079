#pragma once
/// What a debugger controls: chips in one virtual time that can be saved, loaded and run to any instant. A single chip,
/// a network, or the dock.
#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "c40/chip/chip.hpp"
#include "c40/observers/probe.hpp"
#include "machine/time/time.hpp"
#include "toolchain/objects/image.hpp"

namespace machine::debug {

using c40::Address;
using c40::Word;

/// What a debugger says of a chip that stands before SWI.
std::string waits_before_swi(Address pc);

/// An event that is more than an access to one chip's memory: a claim, a missed deadline, a word on a link.
struct DebugEvent {
  Time time{};
  std::string kind;                   ///< "claim"
  std::optional<std::size_t> chip{};  ///< the chip of the event
  std::map<std::string, std::string, std::less<>> fields{};
  std::string text;  ///< one line
};

/// A field of events that a stop condition may ask for. An event tells a number as a decimal one without a sign.
struct EventField {
  std::string name;                  ///< "task"
  bool is_number = true;             ///< of 32 bits
  std::vector<std::string> words{};  ///< what else it may be: "pid"
};

/// A kind of events that a debuggee tells of.
struct EventKind {
  std::string name;        ///< "claim"
  std::string what;        ///< "a DSP claims a task block"
  bool of_chip = false;    ///< such an event is one of a chip; otherwise it is one of no chip
  bool is_common = false;  ///< too frequent for `any`
  std::vector<EventField> fields{};
};

class DebugEventListener {
 public:
  virtual ~DebugEventListener() = default;
  virtual void happened(const DebugEvent& event) = 0;
};

/// An access to a word that several chips can access.
struct SharedAccess {
  Time time{};  ///< after the access
  Address word = 0;
  Word before = 0, value = 0;
  bool write = false;
  std::optional<std::size_t> chip;  ///< none: `who` names it
  std::string who;                  ///< "host"
};

class SharedListener {
 public:
  virtual ~SharedListener() = default;
  virtual void shared_access(const SharedAccess& access) = 0;
};

/// The output of consoles since it was last shown. After going back in time, later output counts as new again.
class ShownOutput {
 public:
  std::string news(std::string all) {
    shown_ = std::min(shown_, all.size());
    return all.substr(std::exchange(shown_, all.size()));
  }

 private:
  std::size_t shown_ = 0;
};

/// Only run_until, load, poke and changed_by_hand change anything; all other functions only read.
class Debuggee {
 public:
  Debuggee() = default;
  Debuggee(const Debuggee&) = delete;
  Debuggee& operator=(const Debuggee&) = delete;
  virtual ~Debuggee() = default;

  virtual std::size_t chips() const = 0;
  virtual std::string chip_name(std::size_t n) const = 0;
  virtual c40::Chip& chip(std::size_t n) = 0;
  virtual const toolchain::Image& program(std::size_t n) const = 0;
  virtual Time time_of(std::size_t n, c40::Cycles cycle) const = 0;
  /// The state of the chip in one sentence.
  virtual std::string describe(std::size_t n) = 0;
  /// Sets the sink of the chip's instructions; null: none.
  virtual void set_trace(std::size_t n, c40::TraceSink* sink) = 0;

  virtual Time now() const = 0;
  /// Why nothing more will happen; none: the run can continue.
  virtual std::optional<std::string> over() const = 0;
  /// The chip that stands before SWI and continues where its PC is set, if it is over for that reason.
  virtual std::optional<std::size_t> calls() const { return std::nullopt; }
  /// To be called when an answer may have come for which the debuggee waited.
  virtual void look_again() {}
  /// To be called after registers or words were changed from outside: what had come to an end may continue.
  /// \param moved the chip whose PC was set: it is not in the instruction that it had begun any more
  virtual void changed_by_hand(std::optional<std::size_t> /*moved*/) {}
  /// Why a PC set now would have no effect, or could not have; none: it can be set.
  virtual std::optional<std::string> holds_pc(std::size_t n);
  /// Executes everything before `time`, and nothing else. Stops earlier when the run is over, or at io::stop_asked().
  virtual void run_until(Time time) = 0;
  /// A suitable length of a run between two checks for hits.
  virtual Time slice() const = 0;
  /// Reports of events and shared words are complete up to this long ago.
  virtual Time delay() const { return Time{0}; }

  virtual std::string save() = 0;
  virtual void load(std::string_view state) = 0;

  /// The word that the chip's program would read, without time or effects; none: it cannot be read like this.
  virtual std::optional<Word> peek(std::size_t n, Address address) = 0;
  /// \throws std::out_of_range
  virtual void poke(std::size_t n, Address address, Word value) = 0;
  /// The number of a word that other chips can access too; none: the word belongs to the chip alone.
  virtual std::optional<Address> shared_word(std::size_t /*n*/, Address /*address*/) const { return std::nullopt; }
  /// `words`: their numbers
  virtual void watch_shared(SharedListener* /*listener*/, std::vector<c40::AddressRange> /*words*/) {}

  virtual std::vector<EventKind> event_kinds() const { return {}; }
  virtual void listen(DebugEventListener* /*listener*/, const std::set<std::string>& /*kinds*/) {}

  /// Names of further values: "plant.payload_z_m".
  virtual std::vector<std::string> value_names() { return {}; }
  virtual std::optional<double> value(std::string_view /*name*/) { return std::nullopt; }
  /// Interval between two looks at values.
  virtual Time value_period() const { return std::chrono::microseconds{125}; }
  /// All output of consoles until now; going back in time shortens it.
  virtual std::string output() { return {}; }
  /// Pages of text that a front end can show: "list", "blocks", "links".
  virtual std::vector<std::string> page_names() const { return {}; }
  virtual std::string page(std::string_view /*name*/) { return {}; }
};

}  // namespace machine::debug
