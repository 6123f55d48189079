// Stop conditions: which are possible, and the list of them.
#include "machine/debug/debugger.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "c40/observers/self_check.hpp"
#include "io/nearest.hpp"
#include "isa/ascii.hpp"
#include "isa/types.hpp"
#include "machine/debug/expression.hpp"
#include "toolchain/objects/written_integer.hpp"

namespace machine::debug {
namespace {

/// Of fields with one name in several kinds of events, one has what any of them may be.
void add_field(std::vector<EventField>& fields, const EventField& field) {
  const auto same = std::ranges::find(fields, field.name, &EventField::name);
  if (same == fields.end()) return fields.push_back(field);
  same->is_number = same->is_number || field.is_number;
  for (const std::string& word : field.words)
    if (std::ranges::find(same->words, word) == same->words.end()) same->words.push_back(word);
}

/// The value of a field as events tell it. \throws DebugError for one that no event has
std::string as_told(const EventField& field, const std::string& value) {
  if (std::ranges::find(field.words, value) != field.words.end()) return value;
  if (!field.is_number)
    throw DebugError(fmt::format("{} is not a {}; {} are possible{}", value, field.name, fmt::join(field.words, ", "),
                                 io::did_you_mean(value, field.words)));
  const bool negative = value.starts_with('-');
  const auto number = toolchain::written_integer(std::string_view(value).substr(negative ? 1 : 0));
  if (!number || *number > (negative ? 0x80000000u : 0xFFFFFFFFu))
    throw DebugError(fmt::format("{}={}: a number of 32 bits (80, 50h, 0x50, -3){}{} is expected", field.name, value,
                                 field.words.empty() ? "" : ", or ", fmt::join(field.words, ", ")));
  return fmt::format("{}", static_cast<Word>(negative ? 0 - *number : *number));
}

DebugError not_to_be_watched(std::string_view name) {
  return DebugError(
      fmt::format("{} is not a register that can be watched; R0 to R11, AR0 to AR7, DP, IR0, IR1, BK, SP, ST, DIE, "
                  "IIE, IIF, RS, RE, RC are",
                  name));
}

}  // namespace

void Debugger::check(const Trigger& trigger) {
  if (trigger.chip) require_chip(*trigger.chip);
  const std::size_t chip = trigger.chip.value_or(0);
  using enum Trigger::Kind;
  for (const CodePlace& place : trigger.places) {
    const auto of = trigger.chip ? trigger.chip : place.chip;
    if (of) require_chip(*of);
    bool there = false;
    for (std::size_t n = of.value_or(0); !there && n < (of ? *of + 1 : programs_.size()); ++n)
      there = debuggee_.peek(n, place.address).has_value();
    if (!there)
      throw DebugError(
          fmt::format("{:08X}h: {} has no memory there", place.address, debuggee_.chip_name(of.value_or(0))));
  }
  if (trigger.kind == word && (trigger.words == 0 || trigger.address + (trigger.words - 1) < trigger.address))
    throw DebugError(fmt::format("{:08X}h: 1 word or more, up to the end of memory, can be watched", trigger.address));
  if (trigger.kind == processor_register && !isa::register_named(trigger.name)) throw not_to_be_watched(trigger.name);
  if (trigger.kind == value) (void)Expression(trigger.name, debuggee_, programs_, chip).value();
  if (trigger.kind == event) {
    const auto kinds = event_kinds();
    if (trigger.name != "any" && std::ranges::find(kinds, trigger.name, &EventKind::name) == kinds.end()) {
      std::vector<std::string_view> names;
      for (const EventKind& kind : kinds) names.push_back(kind.name);
      throw DebugError(fmt::format("{} is not an event; any, {} are possible", trigger.name, fmt::join(names, ", ")));
    }
    if (const auto kind = std::ranges::find(kinds, trigger.name, &EventKind::name);
        trigger.chip && kind != kinds.end() && !kind->of_chip)
      throw DebugError(fmt::format("{} is an event of no chip, so that chip {} never has it", trigger.name, chip));
    (void)as_events_tell(trigger);
  }
  if (!trigger.condition.empty()) (void)Expression(trigger.condition, debuggee_, programs_, chip);
}

std::vector<EventKind> Debugger::event_kinds() const {
  std::vector<EventKind> all = debuggee_.event_kinds();
  EventField rule{.name = "rule", .is_number = false};
  for (const std::string_view name : c40::rule_names()) rule.words.emplace_back(name);
  all.push_back({.name = std::string(Trigger::rules),
                 .what = "an instruction breaks a rule of the manual; checked instruction by instruction",
                 .of_chip = true,
                 .is_common = true,
                 .fields = {rule}});
  return all;
}

/// The trigger with its fields in the form in which events tell them: so the recorder has only texts to compare.
Trigger Debugger::as_events_tell(Trigger trigger) const {
  const auto all = event_kinds();
  std::vector<EventField> fields;
  for (const EventKind& kind : all)
    if (trigger.name == kind.name || (trigger.name == "any" && !kind.is_common))
      for (const EventField& field : kind.fields) add_field(fields, field);
  for (auto& [name, value] : trigger.fields) {
    const auto field = std::ranges::find(fields, name, &EventField::name);
    if (field == fields.end()) {
      std::vector<std::string_view> names;
      for (const EventField& one : fields) names.push_back(one.name);
      if (names.empty()) throw DebugError(fmt::format("{}: {} has no fields", name, trigger.name));
      throw DebugError(fmt::format("{} is not a field of {}; {} are possible{}", name, trigger.name,
                                   fmt::join(names, ", "), io::did_you_mean(name, names)));
    }
    value = as_told(*field, value);
  }
  return trigger;
}

Trigger Debugger::watched(std::size_t chip, std::string_view name) const {
  require_chip(chip);
  if (isa::register_named(name))
    return {.kind = Trigger::Kind::processor_register, .chip = chip, .name = std::string(name)};
  const bool is_other = isa::expansion_named(name) || ascii::same("pc", name);
  if (is_other && !programs_[chip].labelled(name)) throw not_to_be_watched(name);
  return {.kind = Trigger::Kind::word, .chip = chip, .address = word_named(name, debuggee_, programs_, chip)};
}

unsigned Debugger::add(Trigger trigger) {
  check(trigger);
  const unsigned number = next_number_++;
  triggers_.emplace(number, as_events_tell(std::move(trigger)));
  return number;
}

void Debugger::remove(unsigned number) {
  if (triggers_.erase(number) == 0) throw DebugError(fmt::format("there is no stop condition {}", number));
}

void Debugger::enable(unsigned number, bool on) {
  const auto found = triggers_.find(number);
  if (found == triggers_.end()) throw DebugError(fmt::format("there is no stop condition {}", number));
  found->second.enabled = on;
}

}  // namespace machine::debug
