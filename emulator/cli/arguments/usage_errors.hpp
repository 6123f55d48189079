#pragma once
// What is wrong in a command line, and what would be right. The parser's own messages lack the second half.
#include <CLI/CLI.hpp>

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>

namespace cli {

/// Checks of an option's value; the help shows them as the parser's own.
CLI::Validator integer(std::int64_t least, std::int64_t most);
CLI::Validator positive();
CLI::Validator not_negative();
CLI::Validator one_of(std::initializer_list<const char*> words);

/// The message for arguments that `app` could not read. An unknown command or option gets the nearest known name.
std::string usage_error(const CLI::App& app, const CLI::ParseError& error);

/// The message for an option before a command: it belongs to the dock's run, which no command makes.
/// \param of_package the options of the package's commands, which are not declared here
std::optional<std::string> misplaced_option(const CLI::App& app, const CLI::App& of_package);

}  // namespace cli
