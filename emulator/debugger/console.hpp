#pragma once
/// The debugger by commands, a line each: for a terminal and for scripts.
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "machine/debug/debugger.hpp"

namespace debugger {

class Console {
 public:
  using Print = std::function<void(const std::string&)>;
  Console(machine::debug::Debugger& debugger, Print print);

  /// Does a command; an empty line does the last step again. False: it is the end.
  bool command(std::string_view line);
  /// The commands of a file, one a line, # begins a comment. Ends at the first that fails, with status 2, or when an
  /// assertion does not hold, with status 1.
  void script(const std::string& path);
  /// 0; 1: an assertion did not hold; 2: a command of a script made no sense
  int status() const { return status_; }
  /// Words that may stand where the line ends: commands, labels, registers, happenings.
  std::vector<std::string> completions(std::string_view line) const;
  /// "dsp 2> "
  std::string prompt() const;
  /// Where the machine stands.
  void show_stop();

 private:
  struct Words;
  struct Row;
  static const std::vector<Row>& rows();
  const Row* row_named(std::string_view name) const;

  // one for each command
  void stop_at_code(Words& words);
  void stop_at_words(Words& words);
  void stop_at_happening(Words& words);
  void stop_at_value(Words& words);
  void forget(Words& words);
  void enable(Words& words);
  void disable(Words& words);
  void show_stops(Words& words);
  void go(Words& words);
  void back(Words& words);
  void go_to(Words& words);
  void show_last_write(Words& words);
  void choose_chip(Words& words);
  void show_chips(Words& words);
  void print_value(Words& words);
  void show_registers(Words& words);
  void show_peripherals(Words& words);
  void show_memory(Words& words);
  void show_code(Words& words);
  void show_stack(Words& words);
  void show_page(Words& words);
  void show_happenings(Words& words);
  void show_history(Words& words);
  void set(Words& words);
  void assert_that(Words& words);
  void read_script(Words& words);
  void help(Words& words);
  void step(machine::debug::Step step, bool backwards, Words& words);

  unsigned number(Words& words) const;
  void tell(const machine::debug::Stop& stop);
  void added(unsigned number);
  machine::Time time_in(Words& words) const;
  machine::debug::Debuggee& debuggee() { return debugger_.debuggee(); }

  machine::debug::Debugger& debugger_;
  Print print_;
  std::size_t chip_ = 0;
  std::string last_step_;
  machine::debug::ShownOutput output_;
  std::map<std::size_t, std::vector<machine::debug::ShownRegister>> before_,
      now_;  ///< registers at the last two stops, by chip
  int status_ = 0;
  int depth_ = 0;  ///< of scripts in scripts
  bool goes_on_ = true;
};

}  // namespace debugger
