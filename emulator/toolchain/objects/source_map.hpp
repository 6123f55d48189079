#pragma once
// The source lines of an image as text: COFF files contain only file names and line numbers.
#include <filesystem>
#include <string>
#include <string_view>

#include "toolchain/objects/image.hpp"

namespace toolchain {

/// One line per source file and per source line. File names are made relative to `base`.
std::string source_map(const Image& image, const std::filesystem::path& base);

/// Reads the text of an image's lines from the source files: under their own names, else from the folder `beside` under
/// the last part of their names. Lines of a file that is not found, or is shorter, stay without text.
void add_source_text(Image& image, const std::filesystem::path& beside);
/// Where a source file is found only beside, that becomes its name, by which it can be opened.
void name_sources_as_found(Image& image, const std::filesystem::path& beside);

/// Adds files and lines to an image of the same program. Throws std::invalid_argument for a text that is not a source
/// map.
void add_source_map(Image& image, std::string_view map);

}  // namespace toolchain
