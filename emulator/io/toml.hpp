#pragma once
// TOML files of users. All are read by this one function.
#include <toml++/toml.h>

#include <string>
#include <string_view>

namespace io {

/// How deep brackets may stand in one another, and how many parts a dotted key may have. Tables in tables are
/// destroyed, and looked through, by functions that call themselves.
inline constexpr int deepest_toml = 32;

/// \param name of the file, for messages
/// \throws toml::parse_error, also for what is nested deeper than `deepest_toml`
toml::table parse_toml(std::string_view text, const std::string& name);

}  // namespace io
