#pragma once
// The table of the initial values of C's variables (c40-hardware.md 10.2).
#include <string>
#include <vector>

#include "toolchain/linker/placement.hpp"
#include "toolchain/objects/image.hpp"
#include "toolchain/objects/object.hpp"

namespace toolchain {

inline constexpr const char* initial_values = ".cinit";

/// Warnings of what would be lost in silence: the program, and the loader, read the table up to the first count of 0.
/// \param program its name in messages
std::vector<std::string> doubts_about_initial_values(const OutputSection& table, const std::vector<Word>& records,
                                                     const std::vector<Object>& objects, const std::string& program);

/// Sets the values in the image, as the loader does. The table itself stays as a section that reserves nothing: only
/// its name and size. \throws CoffError if it ends within a record
void set_initial_values(Image::Section table, Image& image, const std::string& program);

}  // namespace toolchain
