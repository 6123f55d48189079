#include "cli/arguments/usage_errors.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "io/nearest.hpp"

namespace cli {
namespace {

std::string cannot_be_used(std::string_view value, std::string_view expected) {
  return fmt::format("\"{}\" cannot be used; {} is expected", value, expected);
}

/// The parser's check, with a message of our own.
CLI::Validator worded(CLI::Validator check, std::string expected) {
  std::string description = check.get_description();
  return {[check = std::move(check), expected = std::move(expected)](std::string& text) {
            const std::string given = text;
            return check(text).empty() ? std::string() : cannot_be_used(given, expected);
          },
          std::move(description)};
}

/// Of a value that is not a number the parser says "Could not convert: --option = value" only; the numbers that it
/// reads itself are all integers. Of one that is missing it says "--option: 1 required NAME missing", of an option
/// that is given twice "--option: At Most 1 required but received 2".
std::string in_words(const std::string& message) {
  constexpr std::string_view once = ": At Most 1 required but received ";
  if (const std::size_t begin = message.find(once); begin != std::string::npos)
    return fmt::format("{}: given {} times; once is expected", message.substr(0, begin),
                       message.substr(begin + once.size()));
  constexpr std::string_view one = ": 1 required ", missing = " missing";
  if (const std::size_t begin = message.find(one); begin != std::string::npos && message.ends_with(missing)) {
    const std::size_t value = begin + one.size();
    return fmt::format("{}: its value is missing: {}", message.substr(0, begin),
                       message.substr(value, message.size() - missing.size() - value));
  }
  constexpr std::string_view unconverted = "Could not convert: ", between = " = ";
  const std::size_t end = message.find(between);
  if (!message.starts_with(unconverted) || end == std::string::npos) return message;
  return fmt::format("{}: {}", message.substr(unconverted.size(), end - unconverted.size()),
                     cannot_be_used(message.substr(end + between.size()), "an integer"));
}

std::vector<std::string> commands_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

/// Long options, with their dashes.
std::vector<std::string> options_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

/// \param own the options that the command takes
std::string before_command(const std::string& option, const CLI::App& command, const std::vector<std::string>& own) {
  const bool may_follow = std::ranges::find(own, option) != own.end();
  return fmt::format("{}: before a command it has no effect; {} is expected", option,
                     may_follow ? fmt::format("emulator {} {}", command.get_name(), option)
                                : fmt::format("emulator {} without it", command.get_name()));
}

/// Arguments that are left over.
std::string unexpected(const CLI::App& app, const CLI::App* command) {
  const std::string given = app.remaining(true).front();
  if (given.starts_with("-")) {
    const std::string option = given.substr(0, given.find('='));
    const std::vector<std::string> known = options_of(command ? *command : app);
    if (command != nullptr && std::ranges::find(known, option) != known.end())
      return before_command(option, *command, known);
    const std::string of = command == nullptr ? "" : fmt::format(" of emulator {}", command->get_name());
    return fmt::format("{}: there is no such option{}{}", option, of, io::did_you_mean(option, known));
  }
  if (command != nullptr) return fmt::format("\"{}\" was not expected", given);
  const std::vector<std::string> known = commands_of(app);
  std::string meant = io::did_you_mean(given, known);
  if (given.find('.') != std::string::npos)
    meant = "; emulator exec runs a program";
  else if (meant.empty())
    meant = "; python -m cmrc --help lists those of the Python package";
  return fmt::format("there is no command \"{}\"; {} are known, and without a command the dock runs{}", given,
                     fmt::join(known, ", "), meant);
}

}  // namespace

CLI::Validator integer(std::int64_t least, std::int64_t most) {
  return worded(CLI::Range(least, most, fmt::format("INT in [{} - {}]", least, most)),
                fmt::format("an integer from {} to {}", least, most));
}

CLI::Validator positive() { return worded(CLI::PositiveNumber, "an integer of at least 1"); }

CLI::Validator not_negative() { return worded(CLI::NonNegativeNumber, "an integer of at least 0"); }

CLI::Validator one_of(std::initializer_list<const char*> words) {
  return worded(CLI::IsMember(std::vector<std::string>(words.begin(), words.end())), io::one_of(words));
}

std::string usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<CLI::App*> parsed = app.get_subcommands();
  const CLI::App* command = parsed.empty() ? nullptr : parsed.front();
  const bool left_over = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
  return fmt::format("{} (emulator {}--help lists {}options)",
                     left_over ? unexpected(app, command) : in_words(error.what()),
                     command == nullptr ? "" : command->get_name() + " ", command == nullptr ? "commands and " : "");
}

std::optional<std::string> misplaced_option(const CLI::App& app, const CLI::App& of_package) {
  const std::vector<CLI::App*> parsed = app.get_subcommands();
  if (parsed.empty()) {
    // Behind -- the parser takes a command for an argument.
    for (const CLI::App* command : app.get_subcommands({}))
      if (command->parsed())
        return fmt::format("--: before a command it has no effect; emulator {} is expected", command->get_name());
    return std::nullopt;
  }
  const CLI::App& command = *parsed.front();
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0) continue;
    const std::string name = "--" + option->get_lnames().front();
    return fmt::format("{} (emulator {} --help lists options)",
                       before_command(name, command, options_of(command.get_prefix_command() ? of_package : command)),
                       command.get_name());
  }
  return std::nullopt;
}

}  // namespace cli
