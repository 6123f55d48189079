#pragma once
// TOML files of users. This function reads all of them.
#include <toml++/toml.h>

#include <string>
#include <string_view>

namespace io {

/// How deep brackets may be nested, and how many parts a dotted key may have. Recursive functions visit and destroy
/// nested tables.
inline constexpr int deepest_toml = 32;

/// \param name of the file, for messages
/// \throws toml::parse_error, also for nesting deeper than `deepest_toml`
toml::table parse_toml(std::string_view text, const std::string& name);

}  // namespace io
