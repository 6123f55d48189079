#pragma once
/// The other side of a console, FIFO or mailbox: the words that it sends, when, and in answer to what (docs/boards.md,
/// Host scripts). A script is an input of the run: the same script gives the same run.
#include <cstdint>
#include <deque>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "c40/values/types.hpp"
#include "io/text_error.hpp"
#include "machine/time/time.hpp"
#include "state/visitor.hpp"

namespace machine {

/// The message has the line and what would be right.
class HostScriptError : public io::TextError<std::invalid_argument> {
 public:
  using TextError::TextError;
};

/// A step begins when the step before has been sent. It waits for its condition, and then sends its words.
struct HostStep {
  enum class When : std::uint8_t {
    at,     ///< cycle `number`
    wait,   ///< `number` cycles after the step before
    after,  ///< the program has sent `number` words since the start
    on      ///< the program sends the word `number`, from now on
  } when = When::at;
  std::uint64_t number = 0;
  std::vector<c40::Word> words;
  friend bool operator==(const HostStep&, const HostStep&) = default;
};

/// "at 1000 12h 34h", "wait 50 7", "after 3 0x10", "on 3Eh \"help\n\""; # begins a comment.
/// \param name of the file, for messages
std::vector<HostStep> parse_host_script(std::string_view text, std::string_view name);
/// One word per line in hexadecimal, all available from the start.
std::vector<HostStep> parse_host_words(std::string_view text, std::string_view name);
/// Characters, all available from the start.
std::vector<HostStep> characters(std::string_view text);
/// A script with these steps.
std::string to_text(const std::vector<HostStep>& steps);

class HostScript {
 public:
  HostScript() = default;
  explicit HostScript(std::vector<HostStep> steps) : steps_(steps.begin(), steps.end()) { begin(0); }

  /// Adds steps after those that wait. The first begins in cycle `now` at the earliest.
  void add(const std::vector<HostStep>& steps, c40::Cycles now);
  /// The program has sent a word.
  void heard(c40::Word word, c40::Cycles now);
  /// When the next word is available; never_cycle: the script waits for the program, or is at its end.
  c40::Cycles next() const { return steps_.empty() ? never_cycle : ready_; }
  /// Takes the next word. \param now not before next()
  c40::Word take(c40::Cycles now);
  bool done() const { return steps_.empty(); }

  void list_state(state::Visitor& list);

 private:
  void begin(c40::Cycles now);

  std::deque<HostStep> steps_;  ///< the first one is active
  std::uint64_t word_ = 0;      ///< index in the first step
  std::uint64_t heard_ = 0;
  c40::Cycles ready_ = never_cycle;
};

}  // namespace machine
