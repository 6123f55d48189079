#pragma once
// TI COFF executables of the C3x/C4x, versions 0, 1 and 2 (c40-hardware.md 10.1).
#include <cstddef>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "toolchain/image.hpp"

namespace toolchain {

/// A file that is no COFF executable of this family, or a damaged one. Says where in the file.
class CoffError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads an executable. `name` stands for the file in messages. Sections that a loader skips (DSECT, NOLOAD, COPY, BSS,
/// or without data) come as not loaded. Throws CoffError.
Image read_coff(std::span<const std::byte> bytes, const std::string& name = "<bytes>");
Image read_coff(const std::filesystem::path& path);

/// The bytes of a version-2 executable with all symbols. Reading them back gives the same sections, symbols and entry.
std::vector<std::byte> coff_bytes(const Image& image);

/// Writes the file whole or not at all: to a temporary beside it that is renamed. Throws std::runtime_error.
void write_coff(const Image& image, const std::filesystem::path& path);

}  // namespace toolchain
