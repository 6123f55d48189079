#pragma once
// Command-line flags as settings of the configuration.
#include <optional>
#include <string>
#include <string_view>

#include "cli/arguments/options.hpp"
#include "cmrc/configuration/config.hpp"
#include "io/file_roles.hpp"
#include "report/events/trace_text.hpp"

namespace cli {

/// The text as a TOML value; a word without quotes is a string.
cmrc::Value parse_value(const std::string& text);

/// Applies defaults, preset, file and flags, in this order. \throws cmrc::ConfigError naming the flag, InputError.
/// \param base TOML that comes before all of them, and its name
cmrc::Config build_config(const RunOptions& options, std::string_view base = {}, const std::string& base_name = {});

/// The files from which the configuration comes, so that no output replaces one of them.
io::FileRoles files_read(const RunOptions& options, const cmrc::Config& config);

/// A number of seconds, at least 0; nothing if the text is anything else.
std::optional<report::Time> parse_seconds(std::string_view text);

/// "A:B" in seconds; A or B may be left out. \throws InputError.
report::Window parse_window(std::string_view option, const std::string& text);

}  // namespace cli
