// The commands that show something: registers, memory, code, the stack, pages.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "debugger/console.hpp"
#include "debugger/console_words.hpp"
#include "isa/ascii.hpp"
#include "machine/debug/expression.hpp"

namespace debugger {

using machine::debug::Address;
using machine::debug::DebugError;
using machine::debug::Expression;
using machine::debug::Frame;
using machine::debug::ProgramView;
using machine::debug::ShownRegister;

namespace {

std::string costs(const c40::Causes& causes) {
  c40::Cycles all = 0;
  std::string text;
  for (std::size_t i = 0; i < causes.size(); ++i) {
    all += causes[i];
    if (causes[i] != 0 && static_cast<c40::Cause>(i) != c40::Cause::execute)
      text += fmt::format(" {} {}", name(static_cast<c40::Cause>(i)), causes[i]);
  }
  return fmt::format("{:>6}{}", all, text);
}

}  // namespace

void Console::show_chips(Words& words) {
  words.end();
  for (std::size_t n = 0; n < debugger_.programs().size(); ++n) {
    const Address pc = debuggee().chip(n).pc();
    print_(fmt::format("{} {}  {:08X}h {}  {}", n == chip_ ? "*" : " ", debuggee().chip_name(n), pc,
                       debugger_.program(n).name(pc), debuggee().describe(n)));
  }
}

void Console::print_value(Words& words) {
  const std::string text = words.all();
  print_(Expression(text, debuggee(), debugger_.programs(), chip_).value().text());
}

void Console::show_registers(Words& words) {
  words.end();
  const std::vector<ShownRegister> all = machine::debug::registers(debuggee().chip(chip_));
  const std::vector<ShownRegister>& before = before_[chip_];
  std::string line;
  int column = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool changed = i < before.size() && before[i].hex != all[i].hex;
    const bool wide = all[i].hex.size() > 9;
    line += fmt::format("{}{:<4} {}{}", changed ? '*' : ' ', all[i].name, all[i].hex,
                        wide ? fmt::format("  {:<16}", all[i].value) : "  ");
    column += wide ? 2 : 1;
    if (column >= 4) print_(line), line.clear(), column = 0;
  }
  if (!line.empty()) print_(line);
}

void Console::show_peripherals(Words& words) {
  const std::string wanted(words.next());
  words.end();
  bool shown = false;
  for (const ShownRegister& reg : machine::debug::peripherals(debuggee().chip(chip_))) {
    if (!ascii::same(wanted, std::string_view(reg.name).substr(0, wanted.size()))) continue;
    std::string parts;
    for (const auto& [name, value] : reg.parts)
      if (value != "0") parts += fmt::format("  {}={}", name, value);
    print_(fmt::format("{:<24} {:<10}{}", reg.name, reg.hex, parts));
    shown = true;
  }
  if (!shown) throw DebugError(fmt::format("no peripheral register's name begins with {}", wanted));
}

void Console::show_memory(Words& words) {
  const std::string place = words.place();
  if (place.empty()) throw DebugError("x: a place is expected");
  constexpr std::uint64_t most = 4096;
  const std::uint64_t wanted = words.empty() ? 8 : words.count("words"), count = std::min(wanted, most);
  words.end();
  const Address first = address_at(place, chip_, true);
  for (Address at = 0; at < count; at += 8) {
    std::string line = fmt::format("{:08X}h", first + at);
    for (Address i = at; i < std::min<std::uint64_t>(at + 8, count); ++i) {
      const auto word = debuggee().peek(chip_, first + i);
      line += word ? fmt::format(" {:08X}", *word) : " --------";
    }
    print_(line);
  }
  if (wanted > most)
    print_(fmt::format("{} words at most; the others begin with: x {:08X}h {}", most,
                       first + static_cast<Address>(most), wanted - most));
}

void Console::show_code(Words& words) {
  const std::string place = words.place();
  words.end();
  const ProgramView& program = debugger_.program(chip_);
  const Address pc = debuggee().chip(chip_).pc();
  const Address middle = place.empty() ? pc : machine::debug::places_named(debugger_.programs(), chip_, place).front();
  const auto spent = debugger_.recent_costs(chip_);
  constexpr Address around = 6;
  print_(fmt::format("   {:<10} {:<24} cycles of its last run in the last 200 us", "", ""));
  for (Address at = middle - std::min(middle, around); at <= middle + around; ++at) {
    const auto word = debuggee().peek(chip_, at);
    if (!word) continue;
    if (const auto label = program.label_at(at)) print_(*label + ":");
    const auto cost = spent.find(at);
    std::string text = program.instruction(at, *word);
    std::ranges::replace(text, '\n', ' ');
    std::ranges::replace(text, '\t', ' ');
    print_(fmt::format("{} {:08X}h {:<60} {}", at == pc ? "=>" : "  ", at, ascii::trimmed(text),
                       cost == spent.end() ? "" : costs(cost->second)));
  }
}

void Console::show_stack(Words& words) {
  words.end();
  const ProgramView& program = debugger_.program(chip_);
  int n = 0;
  for (const Frame& frame : machine::debug::call_stack(debuggee(), chip_, program)) {
    const auto source = program.source(frame.pc);
    print_(fmt::format("{:>2} {:08X}h {}{}", n++, frame.pc, program.name(frame.pc),
                       source ? fmt::format(" ({}:{})", source->file, source->line) : ""));
  }
}

void Console::show_page(Words& words) {
  const std::string name(words.next());
  words.end();
  std::string text = debuggee().page(name);
  if (text.ends_with('\n')) text.pop_back();
  print_(text);
}

void Console::show_event_kinds(Words& words) {
  words.end();
  for (const machine::debug::EventKind& kind : debugger_.event_kinds()) {
    std::vector<std::string_view> fields;
    for (const machine::debug::EventField& field : kind.fields) fields.push_back(field.name);
    print_(fmt::format("  {:<16} {}{}", kind.name, kind.what,
                       fields.empty() ? "" : fmt::format(" ({})", fmt::join(fields, ", "))));
  }
  print_("  any              each of them, except events at every bus clock or latch");
}

void Console::show_history(Words& words) {
  words.end();
  const auto info = debugger_.history();
  print_(fmt::format("{} snapshots from {} to {}, {:.1f} MB; {} changes by hand", info.snapshots, seconds(info.first),
                     seconds(info.last), static_cast<double>(info.bytes) * 1e-6, debugger_.changes()));
}

}  // namespace debugger
