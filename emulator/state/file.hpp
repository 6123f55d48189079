#pragma once
/// A state between runs of the emulator: with what it is a state of, and a checksum. What does not fit is refused by
/// name before anything is loaded.
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "state/archive.hpp"

namespace state {

/// The version of the file's envelope and of all lists. It is raised when a list changes its meaning and keeps its
/// names.
inline constexpr unsigned version = 2;

/// What must be the same where the state is loaded: {"board", ...}, {"program of chip 0", ...}. The values may be long:
/// fingerprints of them are kept.
using Key = std::vector<std::pair<std::string, std::string>>;

/// \param kind "processor"
std::string seal(std::string_view kind, const Key& key, Saved state);
/// The kind of a sealed state. \throws StateError for what is none, is another version's, was cut short or changed
std::string kind_of(std::string_view sealed);
/// What was sealed. \throws StateError as kind_of, and for another kind or key
Saved opened(std::string_view sealed, std::string_view kind, const Key& key);

}  // namespace state
