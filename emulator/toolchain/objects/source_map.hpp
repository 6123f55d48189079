#pragma once
// The source lines of an image as text: COFF files carry files and numbers only.
#include <filesystem>
#include <string>
#include <string_view>

#include "toolchain/objects/image.hpp"

namespace toolchain {

/// One line per source file and per source line. File names are made relative to `base`.
std::string source_map(const Image& image, const std::filesystem::path& base);

/// Gives the lines of an image their text, from source files as they are named, else from `beside` or, by their last
/// name, in it. Lines of a file that is not found, or that is shorter, stay without.
void add_source_text(Image& image, const std::filesystem::path& beside);

/// Gives an image of the same program its files and lines. Throws std::invalid_argument for a text that is no source
/// map.
void add_source_map(Image& image, std::string_view map);

}  // namespace toolchain
