#include "debugger/console.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "debugger/console_words.hpp"
#include "io/nearest.hpp"
#include "io/text_form.hpp"
#include "isa/ascii.hpp"
#include "isa/types.hpp"
#include "machine/debug/expression.hpp"

namespace debugger {

using machine::Time;
using machine::debug::Address;
using machine::debug::DebugError;
using machine::debug::Debugger;
using machine::debug::Expression;
using machine::debug::ProgramView;
using machine::debug::ShownRegister;
using machine::debug::Step;
using machine::debug::Stop;
using machine::debug::Trigger;
using machine::debug::Word;

struct Console::Row {
  std::vector<std::string_view> names;  ///< help shows the first name
  std::string_view arguments, purpose;
  std::function<void(Console&, Words&)> act;
};

const std::vector<Console::Row>& Console::rows() {
  const auto step = [](Step how, bool backwards) {
    return [how, backwards](Console& c, Words& w) { c.step(how, backwards, w); };
  };
  static const std::vector<Row> all{
      {{"break", "b"},
       "PLACE [chip N] [ignore N] [log TEXT] [if EXPRESSION]",
       "stop before an instruction: label, label+4, 300000h, FILE:LINE, \"FILE WITH BLANKS:LINE\"",
       [](Console& c, Words& w) { c.stop_at_code(w); }},
      {{"watch", "w"},
       "PLACE[,WORDS]|REGISTER [write|read|access|change] [chip N] [ignore N] [log TEXT] [if EXPRESSION]",
       "stop after an access to words, or after a register has changed",
       [](Console& c, Words& w) { c.stop_at_words(w); }},
      {{"on"},
       "KIND [FIELD=VALUE ...] [chip N] [ignore N] [log TEXT] [if EXPRESSION]",
       "stop at an event (see: kinds)",
       [](Console& c, Words& w) { c.stop_at_event(w); }},
      {{"when"},
       "EXPRESSION",
       "stop when it becomes true, checked every 125 us",
       [](Console& c, Words& w) { c.stop_at_value(w); }},
      {{"stops", "info"},
       "",
       "the stop conditions, and how often each was met",
       [](Console& c, Words& w) { c.show_stops(w); }},
      {{"delete", "d"}, "NUMBER", "remove a stop condition", [](Console& c, Words& w) { c.forget(w); }},
      {{"enable"}, "NUMBER", "use a stop condition again", [](Console& c, Words& w) { c.enable(w); }},
      {{"disable"}, "NUMBER", "do not use a stop condition", [](Console& c, Words& w) { c.disable(w); }},
      {{"continue", "c", "run"},
       "[TIME]",
       "run to the next stop, or to an instant",
       [](Console& c, Words& w) { c.go(w); }},
      {{"back", "rc"}, "", "back to the last stop condition that was met", [](Console& c, Words& w) { c.back(w); }},
      {{"goto"},
       "TIME",
       "go to an instant, before or after now: 2.5 s, 12 ms, 100 us, 7 cycles",
       [](Console& c, Words& w) { c.go_to(w); }},
      {{"stepi", "si"}, "[COUNT]", "one instruction", step(Step::instruction, false)},
      {{"nexti", "ni"}, "[COUNT]", "one instruction; a call with everything in it is one", step(Step::over, false)},
      {{"step", "s"}, "[COUNT]", "to another source line", step(Step::line, false)},
      {{"next", "n"},
       "[COUNT]",
       "to another source line; a call with everything in it is one",
       step(Step::next_line, false)},
      {{"out", "finish"}, "", "to after the call of this routine", step(Step::out, false)},
      {{"block"}, "[COUNT]", "to this DSP's next claim of a task block", step(Step::claim, false)},
      {{"refresh"}, "[COUNT]", "to the host's next refresh of the list", step(Step::refresh, false)},
      {{"event"}, "", "to the next event", step(Step::event, false)},
      {{"rstepi", "rsi"}, "[COUNT]", "one instruction back", step(Step::instruction, true)},
      {{"rnexti", "rni"}, "[COUNT]", "one instruction back, over calls", step(Step::over, true)},
      {{"rstep", "rs"}, "[COUNT]", "one source line back", step(Step::line, true)},
      {{"rnext", "rn"}, "[COUNT]", "one source line back, over calls", step(Step::next_line, true)},
      {{"rout"}, "", "back to the call of this routine", step(Step::out, true)},
      {{"rblock"}, "[COUNT]", "back to this DSP's last claim of a task block", step(Step::claim, true)},
      {{"rrefresh"}, "[COUNT]", "back to the host's last refresh of the list", step(Step::refresh, true)},
      {{"revent"}, "", "back to the last event", step(Step::event, true)},
      {{"lastwrite", "who"}, "PLACE", "the last write to a word", [](Console& c, Words& w) { c.show_last_write(w); }},
      {{"chip", "dsp"}, "[NUMBER]", "choose the chip to show", [](Console& c, Words& w) { c.choose_chip(w); }},
      {{"chips", "dsps"}, "", "the state of all chips", [](Console& c, Words& w) { c.show_chips(w); }},
      {{"print", "p"},
       "EXPRESSION",
       "a value: r0, f(r1), [label + 2], chip1.pc, TIMER0.counter, plant.payload_z_m",
       [](Console& c, Words& w) { c.print_value(w); }},
      {{"registers", "r", "regs"},
       "",
       "all registers; * marks those changed by the last step",
       [](Console& c, Words& w) { c.show_registers(w); }},
      {{"peripherals"},
       "[NAME]",
       "peripheral registers with their fields",
       [](Console& c, Words& w) { c.show_peripherals(w); }},
      {{"x"}, "PLACE [WORDS]", "memory", [](Console& c, Words& w) { c.show_memory(w); }},
      {{"list", "l"},
       "[PLACE]",
       "source or instructions, with the cycles by cause of their last run",
       [](Console& c, Words& w) { c.show_code(w); }},
      {{"stack", "bt", "backtrace"},
       "",
       "the calls of the present routine",
       [](Console& c, Words& w) { c.show_stack(w); }},
      {{"page"},
       "NAME",
       "for the dock list, dsps, plant; for a network chips, events, devices",
       [](Console& c, Words& w) { c.show_page(w); }},
      {{"kinds"}, "", "the kinds of events that `on` takes", [](Console& c, Words& w) { c.show_event_kinds(w); }},
      {{"history"}, "", "the snapshots for going back", [](Console& c, Words& w) { c.show_history(w); }},
      {{"set"},
       "PLACE|REGISTER = EXPRESSION",
       "change a word or a register: a new branch begins",
       [](Console& c, Words& w) { c.set(w); }},
      {{"assert"},
       "EXPRESSION",
       "exit status 1 if it is not true; a script ends there",
       [](Console& c, Words& w) { c.assert_that(w); }},
      {{"source"}, "FILE", "execute the commands of a file", [](Console& c, Words& w) { c.read_script(w); }},
      {{"help", "h", "?"}, "", "this list", [](Console& c, Words& w) { c.help(w); }},
      {{"quit", "q"}, "", "the end", [](Console& c, Words&) { c.continues_ = false; }},
  };
  return all;
}

Console::Console(Debugger& debugger, Print print) : debugger_(debugger), print_(std::move(print)) {
  debugger_.output = [this](const std::string& text) { print_(text); };
  for (std::size_t n = 0; n < debugger_.programs().size(); ++n) now_[n] = machine::debug::registers(debuggee().chip(n));
}

const Console::Row* Console::row_named(std::string_view name) const {
  for (const Row& row : rows())
    if (std::ranges::find(row.names, name) != row.names.end()) return &row;
  return nullptr;
}

std::string Console::prompt() const { return fmt::format("{}> ", debugger_.debuggee().chip_name(chip_)); }

bool Console::command(std::string_view line) {
  failed_ = false;
  line = ascii::trimmed(line);
  if (line.starts_with('#')) return continues_;
  const std::string again = last_step_;
  if (line.empty()) line = again;
  if (line.empty()) return continues_;
  Words words{line};
  const std::string_view name = words.next();
  try {
    const Row* row = row_named(name);
    if (row == nullptr) {
      std::vector<std::string_view> known;
      for (const Row& one : rows()) known.insert(known.end(), one.names.begin(), one.names.end());
      throw DebugError(
          fmt::format("{} is not a command; help lists the commands{}", name, io::did_you_mean(name, known)));
    }
    const bool repeats =
        row->arguments == "[COUNT]" || row->names.front() == "continue" || row->names.front() == "back";
    last_step_ = repeats && depth_ == 0 ? std::string(line) : "";
    row->act(*this, words);
  } catch (const DebugError& error) {
    print_(fmt::format("error: {}", error.what()));
    failed_ = true;
    if (unattended_ && status_ == 0) status_ = 2;
  }
  return continues_;
}

bool Console::unattended(std::string_view line, const std::string& place) {
  const bool before = std::exchange(unattended_, true);
  command(line);
  unattended_ = before;
  if (!failed_) return continues_;
  print_(fmt::format("{}: {}", place, ascii::trimmed(line)));
  return continues_ = false;
}

void Console::script(const std::string& path) {
  if (depth_ > 10) throw DebugError(fmt::format("{}: files nested more than 10 deep", path));
  const std::string text = io::read_text<DebugError>(path, "a file of commands");
  ++depth_;
  paused_ = false;
  int number = 0;
  for (std::size_t at = mark_of_utf8(text); continues_ && !paused_ && at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = ascii::trimmed(std::string_view(text).substr(at, end - at));
    at = end + 1;
    ++number;
    if (!line.empty()) unattended(line, fmt::format("{}:{}", path, number));
  }
  --depth_;
}

// ---- running ----

void Console::tell(const Stop& stop) {
  paused_ = stop.reason == Stop::Reason::paused;
  if (stop.chip) chip_ = *stop.chip;
  now_.swap(before_);
  now_.clear();
  for (std::size_t n = 0; n < debugger_.programs().size(); ++n) now_[n] = machine::debug::registers(debuggee().chip(n));
  show_stop();
}

void Console::show_stop() {
  const Stop& stop = debugger_.stop();
  if (stop.chip && *stop.chip < debugger_.programs().size()) chip_ = *stop.chip;
  if (std::string sent = output_.news(debuggee().output()); !sent.empty()) {
    if (sent.ends_with('\n')) sent.pop_back();
    print_(sent);
  }
  const Address pc = debuggee().chip(chip_).pc();
  const ProgramView& program = debugger_.program(chip_);
  if (stop.reason != Stop::Reason::step || !stop.text.empty())
    print_(fmt::format("{}{}{}", name(stop.reason), stop.text.empty() ? "" : ": ", stop.text));
  const auto source = program.source(pc);
  const auto word = debuggee().peek(chip_, pc);
  print_(fmt::format("{}  {}  {:08X}h {}{}  {}", seconds(stop.time), debuggee().chip_name(chip_), pc, program.name(pc),
                     source ? fmt::format(" ({}:{})", source->file, source->line) : "",
                     word ? program.instruction(pc, *word) : "no memory"));
}

Time Console::time_in(Words& words) const {
  const std::string number(words.next());
  const std::string_view unit = words.next();
  words.end();
  const double value = ascii::number<double>(number).value_or(-1);
  if (!(value >= 0))
    throw DebugError(
        fmt::format("\"{}\" is not an instant; 2.5, 2.5 s, 12 ms, 100 us or 7 cycles is expected", number));
  if (unit == "cycles") return debugger_.debuggee().time_of(chip_, static_cast<c40::Cycles>(std::min(value, 1e15)));
  for (const auto& [name, factor] : {std::pair{"", 1e12}, std::pair{"s", 1e12}, std::pair{"ms", 1e9},
                                     std::pair{"us", 1e6}, std::pair{"ns", 1e3}, std::pair{"ps", 1.0}})
    if (unit == name) {
      if (value * factor > 9e18)
        throw DebugError(fmt::format("{} {}: instants up to 9000000 s are possible", number, unit));
      return Time{std::llround(value * factor)};
    }
  throw DebugError(fmt::format("{} {}: s, ms, us, ns, ps or cycles is expected", number, unit));
}

void Console::go(Words& words) {
  const Time until = words.empty() ? machine::never : time_in(words);
  tell(debugger_.go(until));
}
void Console::back(Words& words) {
  words.end();
  tell(debugger_.go_back());
}
void Console::go_to(Words& words) { tell(debugger_.go_to(time_in(words))); }

void Console::step(Step step, bool backwards, Words& words) {
  std::uint64_t count = words.empty() ? 1 : words.count("how often");
  words.end();
  const std::size_t chip = chip_;
  for (; count != 0; --count) {
    const Stop& stop = backwards ? debugger_.step_back(chip, step) : debugger_.step(chip, step);
    if (stop.reason != Stop::Reason::step) break;
  }
  tell(debugger_.stop());
}

void Console::show_last_write(Words& words) {
  const std::string place = words.place();
  words.end();
  if (place.empty()) throw DebugError("lastwrite: a place is expected");
  const auto writer = debugger_.last_write(chip_, address_at(place, chip_));
  print_(writer ? fmt::format("{}  {}", seconds(writer->time), writer->text)
                : fmt::format("not written since {}", seconds(debugger_.beginning())));
}

// ---- showing ----

void Console::choose_chip(Words& words) {
  if (words.empty()) return show_stop();
  const auto chip = words.count("chip");
  words.end();
  if (chip >= debugger_.programs().size())
    throw DebugError(fmt::format("there is no chip {}; 0 to {} are possible", chip, debugger_.programs().size() - 1));
  chip_ = chip;
  print_(fmt::format("{}: {}", debuggee().chip_name(chip_), debuggee().describe(chip_)));
}

void Console::set(Words& words) {
  const std::string text = words.all();
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw DebugError("set: PLACE = EXPRESSION or REGISTER = EXPRESSION is expected");
  const std::string target(ascii::trimmed(std::string_view(text).substr(0, equals))),
      value(ascii::trimmed(std::string_view(text).substr(equals + 1)));
  if (isa::register_named(target) || isa::expansion_named(target) || ascii::same("pc", target))
    return debugger_.set_register(chip_, target, value);
  const Address address = address_at(target, chip_);
  const auto number = Expression(value, debuggee(), debugger_.programs(), chip_).value();
  if (number.is_float) throw DebugError(fmt::format("{} is a float; a word takes integers", value));
  if (!number.is_word())
    throw DebugError(fmt::format("{} does not fit into a word: 32 bits do, signed or unsigned", value));
  debugger_.set_word(chip_, address, static_cast<Word>(number.integer));
}

Address Console::address_at(const std::string& place, std::size_t chip, bool by_register) {
  return machine::debug::word_named(place, debuggee(), debugger_.programs(), chip, by_register);
}

void Console::assert_that(Words& words) {
  const std::string text = words.all();
  if (Expression(text, debuggee(), debugger_.programs(), chip_).value().truth()) return;
  print_(fmt::format("assertion failed: {} at {}", text, seconds(debugger_.now())));
  failed_ = true;
  status_ = 1;
}

void Console::read_script(Words& words) {
  const std::string file = words.all();
  words.rest = file;
  const std::string quoted = words.place();
  script(words.empty() ? quoted : file);
}

void Console::help(Words& words) {
  words.end();
  for (const Row& row : rows()) {
    std::string names(row.names.front());
    for (std::size_t i = 1; i < row.names.size(); ++i) names += fmt::format(", {}", row.names[i]);
    print_(fmt::format("{:<20} {}\n{:<20} {}", names, row.arguments, "", row.purpose));
  }
  print_("An empty line repeats the last step. Ctrl-C ends a running command. docs/debugger.md says more.");
}

std::vector<std::string> Console::completions(std::string_view line) const {
  const std::size_t begin = line.find_last_of(" \t([+-*/&|^=<>!~,");
  const std::string_view word = line.substr(begin == std::string_view::npos ? 0 : begin + 1);
  std::set<std::string> found;
  const auto offer = [&](std::string_view candidate) {
    if (candidate.starts_with(word)) found.emplace(candidate);
  };
  if (begin == std::string_view::npos) {
    for (const Row& row : rows()) offer(row.names.front());
    return {found.begin(), found.end()};
  }
  for (const auto& [name, value] : debugger_.program(chip_).image().symbols) offer(name);
  for (const machine::debug::EventKind& kind : debugger_.event_kinds()) offer(kind.name);
  for (const std::string& name : debugger_.debuggee().value_names()) offer(name);
  for (const std::string& name : debugger_.debuggee().page_names()) offer(name);
  for (const ShownRegister& reg : machine::debug::registers(debugger_.debuggee().chip(chip_)))
    offer(ascii::lower(reg.name));
  return {found.begin(), found.end()};
}

}  // namespace debugger
