// The commands for stop conditions.
#include <fmt/format.h>

#include <array>

#include "debugger/console.hpp"
#include "debugger/console_words.hpp"
#include "isa/ascii.hpp"
#include "machine/debug/inspect.hpp"
#include "toolchain/objects/image.hpp"

namespace debugger {

using machine::debug::DebugError;
using machine::debug::Trigger;

namespace {

/// A word "FIELD=VALUE" of an event.
template <class Words>
bool take_field(Words& words, Trigger& trigger) {
  const std::string_view word = words.peek();
  const std::size_t equals = word.find('=');
  if (equals == std::string_view::npos || equals == 0) return false;
  const std::string field(word.substr(0, equals));
  if (!trigger.fields.emplace(field, word.substr(equals + 1)).second)
    throw DebugError(fmt::format("{}: the field is there twice", field));
  words.next();
  return true;
}

/// Where "log" stands as a word behind other text, and before other text.
std::size_t log_in(std::string_view text) {
  constexpr std::string_view log = "log";
  for (std::size_t at = text.find(log, 1); at != std::string_view::npos; at = text.find(log, at + 1))
    if (is_blank(text[at - 1]) && at + log.size() < text.size() && is_blank(text[at + log.size()])) return at;
  return std::string_view::npos;
}

/// "chip N", "ignore N", "log TEXT", "if EXPRESSION" in any order; of an event "FIELD=VALUE", too. Of `log` and `if`,
/// the first one ends where the other one begins, and the other one takes the rest of the line. A # in the text of a
/// log is text.
template <class Words>
void read_options(Words& words, Trigger& trigger) {
  for (;;) {
    if (trigger.kind == Trigger::Kind::event && take_field(words, trigger)) continue;
    if (words.take("chip") || words.take("dsp")) {
      trigger.chip = words.count("chip");
    } else if (words.take("ignore")) {
      trigger.ignore = words.count("ignore");
    } else if (const bool log_first = words.take("log"); log_first || words.take("if")) {
      const std::string_view text = words.text();
      bool has_log = log_first;
      if (log_first) {
        const std::size_t at = text.rfind(" if ");
        trigger.log = ascii::trimmed(text.substr(0, at));
        if (at != std::string_view::npos) trigger.condition = without_comment(text.substr(at + 4));
      } else if (const std::size_t at = log_in(text); at < comment_in(text)) {
        trigger.condition = ascii::trimmed(text.substr(0, at));
        trigger.log = ascii::trimmed(text.substr(at + 3));
        has_log = true;
      } else {
        trigger.condition = without_comment(text);
      }
      if (!log_first && trigger.condition.empty()) throw DebugError("if: an expression is expected");
      if (has_log && trigger.log.empty()) throw DebugError("log: a text is expected; it may contain {expressions}");
      return;
    } else {
      return words.end();
    }
  }
}

}  // namespace

void Console::added(unsigned number) {
  const Trigger& trigger = debugger_.triggers().at(number);
  print_(fmt::format(
      "{}: {}{}", number, trigger.text,
      trigger.kind == Trigger::Kind::processor_register ? " (this chip runs by single instructions now: slow)" : ""));
}

void Console::stop_at_code(Words& words) {
  const std::string place = words.place();
  if (place.empty()) throw DebugError("break: a place is expected: a label, label+4, 300000h, FILE:LINE");
  Trigger trigger{.kind = Trigger::Kind::code};
  read_options(words, trigger);
  if (trigger.chip && *trigger.chip >= debugger_.programs().size())
    throw DebugError(fmt::format("there is no chip {}", *trigger.chip));
  trigger.places = machine::debug::code_named(debugger_.programs(), trigger.chip, place);
  std::vector<machine::debug::CodePlace> shown = trigger.places;
  for (auto& one : shown)
    if (trigger.chip) one.chip = trigger.chip;
  trigger.text = "before " + machine::debug::text_of(shown, debugger_.programs(), debuggee());
  added(debugger_.add(trigger));
}

void Console::stop_at_words(Words& words) {
  using On = Trigger::On;
  const std::string place = words.place();
  if (place.empty()) throw DebugError("watch: a place or a register is expected");
  Trigger given{.kind = Trigger::Kind::word};
  const std::string access(words.peek());
  bool says_access = false;
  for (const auto& [name, on] : {std::pair{"write", On::write}, std::pair{"read", On::read},
                                 std::pair{"access", On::access}, std::pair{"change", On::change}})
    if (!says_access && words.take(name)) given.on = on, says_access = true;
  read_options(words, given);
  const std::size_t chip = given.chip.value_or(chip_), comma = place.find(',');
  Trigger trigger;
  if (comma == std::string::npos) {
    trigger = debugger_.watched(chip, place);
  } else {
    const auto count = toolchain::find_address(place.substr(comma + 1), nullptr);
    if (!count || *count == 0) throw DebugError(fmt::format("watch {}: PLACE,WORDS is expected", place));
    trigger = {.kind = Trigger::Kind::word, .chip = chip, .words = *count};
    trigger.address = address_at(place.substr(0, comma), chip);
  }
  trigger.on = given.on;
  trigger.condition = given.condition, trigger.log = given.log, trigger.ignore = given.ignore;
  if (trigger.kind == Trigger::Kind::processor_register) {
    if (says_access && given.on != On::change)
      throw DebugError(fmt::format("watch {} {}: of a register, only changes can be watched", place, access));
    trigger.text = fmt::format("after a change of {} of {}", place, debuggee().chip_name(chip));
    return added(debugger_.add(trigger));
  }
  constexpr std::array names{"writes to", "reads of", "accesses to", "changes of"};
  trigger.text =
      fmt::format("after {} {} ({:08X}h{}) as {} sees it", names[static_cast<std::size_t>(trigger.on)],
                  debugger_.program(chip).name(trigger.address), trigger.address,
                  trigger.words == 1 ? "" : fmt::format(", {} words", trigger.words), debuggee().chip_name(chip));
  added(debugger_.add(trigger));
}

void Console::stop_at_event(Words& words) {
  Trigger trigger{.kind = Trigger::Kind::event, .name = std::string(words.next())};
  if (trigger.name.empty()) throw DebugError("on: an event is expected (see: kinds)");
  read_options(words, trigger);
  trigger.text = "at " + trigger.name;
  for (const auto& [field, value] : trigger.fields) trigger.text += fmt::format(" {}={}", field, value);
  if (trigger.chip) trigger.text += fmt::format(" chip {}", *trigger.chip);
  added(debugger_.add(trigger));
}

void Console::stop_at_value(Words& words) {
  Trigger trigger{.kind = Trigger::Kind::value, .chip = chip_, .name = words.all()};
  if (trigger.name.empty()) throw DebugError("when: an expression is expected");
  trigger.text = "when " + trigger.name;
  added(debugger_.add(trigger));
}

unsigned Console::number(Words& words) const {
  const auto number = words.count("a stop condition's number");
  words.end();
  return static_cast<unsigned>(number);
}

void Console::forget(Words& words) { debugger_.remove(number(words)); }
void Console::enable(Words& words) { debugger_.enable(number(words), true); }
void Console::disable(Words& words) { debugger_.enable(number(words), false); }

void Console::show_stops(Words& words) {
  words.end();
  if (debugger_.triggers().empty()) return print_("no stop conditions");
  for (const auto& [number, trigger] : debugger_.triggers())
    print_(fmt::format("{}: {}{}{}{}{}, met {} times{}", number, trigger.text,
                       trigger.condition.empty() ? "" : " if " + trigger.condition,
                       trigger.ignore == 0 ? "" : fmt::format(", the first {} ignored", trigger.ignore),
                       trigger.log.empty() ? "" : ", tells: " + trigger.log, "", trigger.hits,
                       trigger.enabled ? "" : " (disabled)"));
}

}  // namespace debugger
