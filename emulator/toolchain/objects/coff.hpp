#pragma once
// TI COFF files of the C3x/C4x, versions 0, 1 and 2 (c40-hardware.md 10.1).
#include <cstddef>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "io/text_error.hpp"
#include "toolchain/objects/image.hpp"
#include "toolchain/objects/object.hpp"

namespace toolchain {

/// A file that is not a COFF file of this family, or is damaged. The message names the place in the file.
class CoffError : public io::TextError<std::runtime_error> {
 public:
  using TextError::TextError;
};

/// Reads a file of version 0, 1 or 2, with headers of either byte order. Skips debugging symbols, except the names of
/// source files and the lines. `name` is the file's name in messages. Throws CoffError.
Object read_object(std::span<const std::byte> bytes, const std::string& name = "<bytes>");
Object read_object(const std::filesystem::path& path);

/// Reads an executable. Sections that a loader skips (DSECT, NOLOAD, COPY, BSS, or without data) are marked as not
/// loaded; the initial values of a .cinit of type COPY become sections of their own. Throws CoffError.
Image read_coff(std::span<const std::byte> bytes, const std::string& name = "<bytes>");
/// The text of the source lines comes from the source files, if they are found (source_map.hpp).
Image read_coff(const std::filesystem::path& path);

/// The bytes of a file of the object's version. Names of sections are cut to eight characters, but their symbols keep
/// the whole name. Throws std::runtime_error for contents that the version does not support, CoffError for an
/// executable without a word.
std::vector<std::byte> coff_bytes(const Object& object);
/// The bytes of a version-2 executable with all symbols. Reading them back gives the same sections, symbols and entry.
std::vector<std::byte> coff_bytes(const Image& image);

void write_coff(const Object& object, std::ostream& out);
/// Writes the file whole or not at all. Throws io::CannotOpen, std::runtime_error.
void write_coff(const Object& object, const std::filesystem::path& path);
void write_coff(const Image& image, const std::filesystem::path& path);

/// The bytes of a file. Throws CoffError.
std::vector<std::byte> read_bytes(const std::filesystem::path& path);

}  // namespace toolchain
