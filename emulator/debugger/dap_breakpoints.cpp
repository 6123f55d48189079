// The client's stop conditions. Each request sends all conditions of its kind again.
#include <fmt/format.h>

#include <algorithm>

#include "debugger/dap_session.hpp"
#include "isa/ascii.hpp"

namespace debugger::dap {

namespace core_ns = machine::debug;
using core_ns::Address;
using core_ns::code_named;
using core_ns::CodePlace;
using core_ns::DebugError;
using core_ns::Trigger;
using core_ns::with_same_program;

namespace {

const Json& list_of(const Json& from, std::string_view key) {
  static const Json none = Json::array();
  const auto found = from.find(key);
  return found != from.end() && found->is_array() ? *found : none;
}

/// The number of hits to ignore, from "5", ">= 5", "> 4".
std::uint64_t passed_over(std::string text) {
  text.erase(std::remove(text.begin(), text.end(), ' '), text.end());
  if (text.empty()) return 0;
  std::uint64_t add = 0;
  std::string_view rest = text;
  if (rest.starts_with(">="))
    rest.remove_prefix(2);
  else if (rest.starts_with(">"))
    rest.remove_prefix(1), add = 1;
  const auto count = ascii::number<std::uint64_t>(rest);
  if (!count || *count + add == 0)
    throw DebugError(fmt::format("hitCondition \"{}\": a number, >= or > and a number are expected", text));
  return *count + add - 1;
}

void read_conditions(const Json& asked, Trigger& trigger) {
  trigger.condition = text_of(asked, "condition");
  trigger.ignore = passed_over(text_of(asked, "hitCondition"));
  trigger.log = text_of(asked, "logMessage");
}

}  // namespace

void Session::forget(std::vector<unsigned>& numbers) {
  for (const unsigned number : numbers)
    if (core().triggers().contains(number)) core().remove(number);
  numbers.clear();
}

/// An impossible breakpoint; clients nevertheless need a number for it.
Json Session::refused_breakpoint(const std::string& why) {
  constexpr unsigned behind_all_others = 1u << 30;
  return {{"verified", false}, {"message", why}, {"id", behind_all_others + refused_++}};
}

/// The answer for one requested breakpoint.
Json Session::add_breakpoint(Trigger trigger, const Json& asked, std::vector<unsigned>& numbers) {
  try {
    read_conditions(asked, trigger);
    numbers.push_back(core().add(std::move(trigger)));
    return {{"verified", true}, {"id", numbers.back()}};
  } catch (const DebugError& error) {
    return refused_breakpoint(error.what());
  }
}

/// One breakpoint, with one number and one count, wherever its code stands.
Json Session::add_code_breakpoint(std::vector<CodePlace> places, const Json& asked, std::vector<unsigned>& numbers) {
  const CodePlace first = places.front();
  Json answer = add_breakpoint(Trigger{.kind = Trigger::Kind::code, .places = std::move(places)}, asked, numbers);
  answer["instructionReference"] = reference({first.chip.value_or(0), first.address});
  return answer;
}

/// The files that the client means by a source: by its reference, else its path, else its name.
core_ns::FilesNamed Session::files_of(const Json& source) {
  const auto number = source.find("sourceReference");
  if (number != source.end() && number->is_number_unsigned()) {
    const auto found = number->get<std::size_t>();
    if (found != 0 && found <= sources_.size()) {
      const BuiltIn& one = sources_[found - 1];
      const auto& files = core().program(one.chip).files();
      return core_ns::FilesNamed::only(core().programs(), one.chip,
                                       static_cast<std::size_t>(std::ranges::find(files, one.file) - files.begin()));
    }
  }
  const std::string path = path_from_client(text_of(source, "path"));
  return {core().programs(), std::nullopt, path.empty() ? text_of(source, "name") : path};
}

Json Session::set_breakpoints(const Json& arguments) {
  core();
  const Json& asked_source = arguments.at("source");
  const core_ns::FilesNamed files = files_of(asked_source);
  std::string file = path_from_client(text_of(asked_source, "path"));
  if (file.empty()) file = text_of(asked_source, "name");
  if (file.empty()) file = fmt::format("source {}", asked_source.value("sourceReference", 0));
  std::vector<unsigned>& numbers = by_source_[file];
  forget(numbers);
  Json answers = Json::array();
  for (const Json& asked : list_of(arguments, "breakpoints")) {
    const int line = from_client(asked.at("line"));
    const std::vector<CodePlace> places = files.code(line);
    if (places.empty()) {
      answers.push_back(
          refused_breakpoint(fmt::format("there is no instruction in line {} of {} or after it", line, file)));
      continue;
    }
    const std::size_t chip = places.front().chip.value_or(0);
    const auto place = core().program(chip).source(places.front().address);
    Json answer = add_code_breakpoint(places, asked, numbers);
    answer["line"] = to_client(place ? place->line : line);
    if (place) answer["source"] = source_of(chip, place->file);
    answers.push_back(std::move(answer));
  }
  return {{"breakpoints", answers}};
}

Json Session::set_function_breakpoints(const Json& arguments) {
  forget(by_function_);
  Json answers = Json::array();
  for (const Json& asked : list_of(arguments, "breakpoints")) {
    const std::string name = text_of(asked, "name");
    const bool known =
        std::ranges::any_of(core().programs(), [&](const auto& p) { return p.address(name).has_value(); });
    answers.push_back(known
                          ? add_code_breakpoint(code_named(core().programs(), std::nullopt, name), asked, by_function_)
                          : refused_breakpoint(fmt::format("no program has a label {}", name)));
  }
  return {{"breakpoints", answers}};
}

Json Session::set_instruction_breakpoints(const Json& arguments) {
  forget(by_instruction_);
  Json answers = Json::array();
  for (const Json& asked : list_of(arguments, "breakpoints")) {
    try {
      const Place place = place_of(asked, "instructionReference");
      answers.push_back(
          add_code_breakpoint(with_same_program(core().programs(), place.chip, place.address), asked, by_instruction_));
    } catch (const DebugError& error) {
      answers.push_back(refused_breakpoint(error.what()));
    }
  }
  return {{"breakpoints", answers}};
}

Json Session::set_exception_breakpoints(const Json& arguments) {
  forget(by_exception_);
  const auto there = core().event_kinds();
  Json answers = Json::array();
  for (const Json& filter : list_of(arguments, "filters")) {
    const std::string kind = filter.get<std::string>();
    if (std::ranges::find(there, kind, &core_ns::EventKind::name) == there.end())
      answers.push_back(refused_breakpoint(fmt::format("there are no events {} here", kind)));
    else
      answers.push_back(add_breakpoint({.kind = Trigger::Kind::event, .name = kind}, Json::object(), by_exception_));
  }
  return {{"breakpoints", answers}};
}

/// The watched object is "CHIP:ADDRESS:WORDS" or "CHIP:REGISTER".
Json Session::data_breakpoint_info(const Json& arguments) {
  const std::string name = text_of(arguments, "name");
  const auto reference = arguments.find("variablesReference");
  const bool is_shown = reference != arguments.end() && reference->is_number_integer() && *reference != 0;
  const std::size_t chip_of_text = chip_of_frame(arguments);
  try {
    Trigger watched;
    if (!is_shown) {
      watched = core().watched(chip_of_text, name);
    } else if (const auto scope = registers_shown_.find(reference->get<std::int64_t>());
               scope == registers_shown_.end()) {
      throw DebugError(
          fmt::format("{} is a part of what is shown; only whole registers and words can be watched", name));
    } else {
      watched = core().watched(scope->second.chip, name);
      // What has a label of the same name is another word.
      if (!scope->second.of_peripherals && watched.kind != Trigger::Kind::processor_register)
        throw DebugError(fmt::format("{} is not a register that can be watched", name));
    }
    const std::size_t chip = *watched.chip;
    const std::string of = core().debuggee().chip_name(chip);
    if (watched.kind == Trigger::Kind::processor_register)
      return {{"dataId", fmt::format("{}:{}", chip, name)},
              {"description", fmt::format("{} of {}; that chip then runs by single instructions", name, of)},
              {"accessTypes", {"write"}},
              {"canPersist", true}};
    return {{"dataId", fmt::format("{}:{}:1", chip, watched.address)},
            {"description", fmt::format("the word at {:08X}h of {}", watched.address, of)},
            {"accessTypes", {"read", "write", "readWrite"}},
            {"canPersist", true}};
  } catch (const DebugError& error) {
    return {{"dataId", nullptr}, {"description", error.what()}};
  }
}

Json Session::set_data_breakpoints(const Json& arguments) {
  forget(by_data_);
  Json answers = Json::array();
  for (const Json& asked : list_of(arguments, "breakpoints")) {
    const std::string id = text_of(asked, "dataId"), access = text_of(asked, "accessType");
    const std::size_t first = id.find(':'), last = id.rfind(':');
    Trigger trigger{.kind = Trigger::Kind::word,
                    .on = access == "read"        ? Trigger::On::read
                          : access == "readWrite" ? Trigger::On::access
                                                  : Trigger::On::write};
    const auto chip = toolchain::find_address(id.substr(0, first), nullptr);
    if (first == std::string::npos || !chip) {
      answers.push_back(
          refused_breakpoint(fmt::format("dataId \"{}\": one that dataBreakpointInfo gave is expected", id)));
      continue;
    }
    trigger.chip = *chip;
    const bool of_word = first != last;
    if (!access.empty() && access != "write" && !(of_word && (access == "read" || access == "readWrite"))) {
      answers.push_back(refused_breakpoint(
          fmt::format("accessType \"{}\": {} is expected", access, of_word ? "read, write or readWrite" : "write")));
      continue;
    }
    if (!of_word) {
      trigger.kind = Trigger::Kind::processor_register;
      trigger.name = id.substr(first + 1);
    } else {
      trigger.address = toolchain::find_address(id.substr(first + 1, last - first - 1), nullptr).value_or(0);
      trigger.words = std::max<Address>(toolchain::find_address(id.substr(last + 1), nullptr).value_or(1), 1);
    }
    answers.push_back(add_breakpoint(std::move(trigger), asked, by_data_));
  }
  return {{"breakpoints", answers}};
}

Json Session::breakpoint_locations(const Json& arguments) {
  constexpr int most = 1000;
  const int from = from_client(arguments.at("line")),
            to = arguments.contains("endLine") ? from_client(arguments["endLine"]) : from;
  Json places = Json::array();
  for (const int line : files_of(arguments.at("source")).lines(from, std::min(to, from + most)))
    places.push_back({{"line", to_client(line)}});
  return {{"breakpoints", places}};
}

}  // namespace debugger::dap
