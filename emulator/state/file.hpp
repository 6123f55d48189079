#pragma once
/// A saved state as a file: what it is of, the version, a checksum, and parts of text.
///
///     magic "C40STATE", format 1 (8 bytes), SHA-256 of all that follows (64 digits), then length (8 bytes) and text of: what it is
///     of, the version of the emulator, and each part: its length (8 bytes), and the part as zlib packs it.
#include <string>
#include <string_view>
#include <vector>

#include "state/visitor.hpp"

namespace state {

/// \param kind what it is of: "run", "processor", "network"
std::string sealed(std::string_view kind, const std::vector<std::string_view>& parts);

/// The parts of a file. \throws StateError for what is no such file, is cut short or damaged, or is of another kind or version
std::vector<std::string> opened(std::string_view file, std::string_view kind, std::size_t parts);

}  // namespace state
