#pragma once
/// A state between runs of the emulator, with a description of its object and a checksum. A state that does not fit is
/// refused with the name of the difference, before anything is loaded.
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "state/archive.hpp"

namespace state {

/// The version of the file's envelope and of all lists. Raise it if a list changes its meaning but not its names.
inline constexpr unsigned version = 4;

/// What must be the same where the state is loaded: {"board", ...}, {"program of chip 0", ...}. The values may be long:
/// only their fingerprints are kept.
using Key = std::vector<std::pair<std::string, std::string>>;

/// \param kind "processor"
std::string seal(std::string_view kind, const Key& key, Saved state);
/// The kind of a sealed state. \throws StateError for a text that is not one, is of another version, was cut short or
/// changed
std::string kind_of(std::string_view sealed);
/// The sealed state. \throws StateError as kind_of, and for another kind or key
Saved opened(std::string_view sealed, std::string_view kind, const Key& key);

}  // namespace state
