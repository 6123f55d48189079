#pragma once
// The source lines of an image as text, for images whose file format has no room for them (COFF files carry none).
#include <filesystem>
#include <string>
#include <string_view>

#include "toolchain/image.hpp"

namespace toolchain {

/// One line per source file and per source line. File names are made relative to `base`.
std::string source_map(const Image& image, const std::filesystem::path& base);

/// Gives an image of the same program its files and lines. Throws std::invalid_argument for a text that is no source map.
void add_source_map(Image& image, std::string_view map);

}  // namespace toolchain
