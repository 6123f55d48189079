// Stop conditions: which are possible, and the list of them.
#include "machine/debug/debugger.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "c40/observers/self_check.hpp"
#include "isa/types.hpp"
#include "machine/debug/expression.hpp"

namespace machine::debug {

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
  if (trigger.kind == processor_register && !isa::register_named(trigger.name))
    throw DebugError(fmt::format(
        "{} is not a register that can be watched; R0 to R11, AR0 to AR7, DP, IR0, IR1, BK, SP, ST, DIE, IIE, "
        "IIF, RS, RE, RC are",
        trigger.name));
  if (trigger.kind == value) (void)Expression(trigger.name, debuggee_, programs_, chip).value();
  if (trigger.kind == event) {
    const auto kinds = event_kinds();
    if (trigger.name != "any" &&
        std::ranges::none_of(kinds, [&](const auto& row) { return row.first == trigger.name; })) {
      std::vector<std::string_view> names;
      for (const auto& [name, meaning] : kinds) names.push_back(name);
      throw DebugError(fmt::format("{} is not an event; any, {} are possible", trigger.name, fmt::join(names, ", ")));
    }
    const std::vector<std::string_view> rules = c40::rule_names();
    if (const auto rule = trigger.fields.find("rule");
        trigger.of_rules() && rule != trigger.fields.end() && std::ranges::find(rules, rule->second) == rules.end())
      throw DebugError(fmt::format("{} is not a rule; {} are possible", rule->second, fmt::join(rules, ", ")));
  }
  if (!trigger.condition.empty()) (void)Expression(trigger.condition, debuggee_, programs_, chip);
}

std::vector<std::pair<std::string, std::string>> Debugger::event_kinds() const {
  auto all = debuggee_.event_kinds();
  all.emplace_back(
      std::string(Trigger::rules),
      "an instruction breaks a rule of the manual (rule=NAME: one of them); checked instruction by instruction");
  return all;
}

unsigned Debugger::add(Trigger trigger) {
  check(trigger);
  const unsigned number = next_number_++;
  triggers_.emplace(number, std::move(trigger));
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
