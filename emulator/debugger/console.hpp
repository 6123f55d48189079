#pragma once
/// The debugger as a console with one command per line: for a terminal and for scripts.
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "machine/debug/debugger.hpp"

namespace debugger {

class Console {
 public:
  using Print = std::function<void(const std::string&)>;
  Console(machine::debug::Debugger& debugger, Print print);

  /// Executes a command that somebody types; an empty line repeats the last step. False: the end.
  bool command(std::string_view line);
  /// Executes a command where nobody sees the answer: if it fails, that is the end, with status 2, and if it is an
  /// assertion that is false, with status 1. \param place where it stands, for the message. False: the end.
  bool unattended(std::string_view line, const std::string& place);
  /// Executes the commands of a file like that, one per line; # begins a comment. \throws machine::debug::DebugError
  void script(const std::string& path);
  /// 0; 1: an assertion was false; 2: an unattended command failed
  int status() const { return status_; }
  /// Ctrl-C has ended the last command that moved the machine.
  bool paused() const { return paused_; }
  /// Words that could complete the line: commands, labels, registers, events.
  std::vector<std::string> completions(std::string_view line) const;
  /// "dsp 2> "
  std::string prompt() const;
  /// Shows where the machine is.
  void show_stop();

 private:
  struct Words;
  struct Row;
  static const std::vector<Row>& rows();
  const Row* row_named(std::string_view name) const;

  // one for each command
  void stop_at_code(Words& words);
  void stop_at_words(Words& words);
  void stop_at_event(Words& words);
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
  void show_event_kinds(Words& words);
  void show_history(Words& words);
  void set(Words& words);
  void assert_that(Words& words);
  void read_script(Words& words);
  void help(Words& words);
  void step(machine::debug::Step step, bool backwards, Words& words);

  unsigned number(Words& words) const;
  machine::debug::Address address_at(const std::string& place, std::size_t chip, bool by_register = false);
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
  int depth_ = 0;            ///< depth of nested scripts
  bool unattended_ = false;  ///< the present command is
  bool failed_ = false;      ///< the last command has
  bool continues_ = true;
  bool paused_ = false;  ///< Ctrl-C has ended the last command that moved the machine: its script ends, too
};

}  // namespace debugger
