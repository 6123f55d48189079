#pragma once
/// What a debugger drives: chips in one virtual time, which can be saved, loaded and run to any instant. A chip alone,
/// a network, the dock.
#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "c40/chip.hpp"
#include "c40/probe.hpp"
#include "machine/time.hpp"
#include "toolchain/objects/image.hpp"

namespace machine::debug {

using c40::Address;
using c40::Word;

/// Something that happens to more than one chip's memory: a claim, a missed deadline, a word on a link.
struct DebugEvent {
  Time time{};
  std::string kind;                   ///< "claim"
  std::optional<std::size_t> chip{};  ///< whose
  std::map<std::string, std::string, std::less<>> fields{};
  std::string text;  ///< one line
};

class DebugEventListener {
 public:
  virtual ~DebugEventListener() = default;
  virtual void happened(const DebugEvent& happening) = 0;
};

/// A word that several chips reach, and who touched it.
struct SharedAccess {
  Time time{};  ///< afterwards
  Address word = 0;
  Word before = 0, value = 0;
  bool write = false;
  std::optional<std::size_t> chip;  ///< none: `who` says it
  std::string who;                  ///< "host"
};

class SharedListener {
 public:
  virtual ~SharedListener() = default;
  virtual void shared_access(const SharedAccess& access) = 0;
};

/// What consoles have sent since it was last shown. After time went back, what was sent from there on is new again.
class ShownOutput {
 public:
  std::string news(std::string all) {
    shown_ = std::min(shown_, all.size());
    return all.substr(std::exchange(shown_, all.size()));
  }

 private:
  std::size_t shown_ = 0;
};

/// What looks changes nothing: everything but run_until, load and poke.
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
  /// How the chip stands, in one sentence.
  virtual std::string describe(std::size_t n) = 0;
  /// Who hears the chip's instructions; null: nobody.
  virtual void set_trace(std::size_t n, c40::TraceSink* sink) = 0;

  virtual Time now() const = 0;
  /// Why nothing more will happen; none: it goes on.
  virtual std::optional<std::string> over() const = 0;
  /// Somebody may have answered what it waited for.
  virtual void look_again() {}
  /// Everything before `time` happens, and nothing else. Less when it is over, or io::stop_asked().
  virtual void run_until(Time time) = 0;
  /// A good length to run between two looks at what has been hit.
  virtual Time slice() const = 0;
  /// What has been told of happenings and shared words is complete up to so long ago.
  virtual Time delay() const { return Time{0}; }

  virtual std::string save() = 0;
  virtual void load(std::string_view state) = 0;

  /// The word that the chip's program would read, without time or effects; none: nothing can be read there so.
  virtual std::optional<Word> peek(std::size_t n, Address address) = 0;
  /// \throws std::out_of_range
  virtual void poke(std::size_t n, Address address, Word value) = 0;
  /// The number of a word that others reach as well; none: it is the chip's own.
  virtual std::optional<Address> shared_word(std::size_t /*n*/, Address /*address*/) const { return std::nullopt; }
  /// `words`: by number
  virtual void watch_shared(SharedListener* /*listener*/, std::vector<c40::AddressRange> /*words*/) {}

  /// Kinds of happenings, with what they are.
  virtual std::vector<std::pair<std::string, std::string>> happenings() const { return {}; }
  virtual void listen(DebugEventListener* /*listener*/, const std::set<std::string>& /*kinds*/) {}

  /// What else has a value: "plant.payload_z_m".
  virtual std::vector<std::string> value_names() { return {}; }
  virtual std::optional<double> value(std::string_view /*name*/) { return std::nullopt; }
  /// Values are looked at so often.
  virtual Time value_period() const { return std::chrono::microseconds{125}; }
  /// What consoles have sent up to now: goes back with time.
  virtual std::string output() { return {}; }
  /// Pages of text that a front end may show: "list", "blocks", "links".
  virtual std::vector<std::string> page_names() const { return {}; }
  virtual std::string page(std::string_view /*name*/) { return {}; }
};

}  // namespace machine::debug
