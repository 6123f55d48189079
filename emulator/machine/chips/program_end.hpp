#pragma once
// How a program ends: IDLE, or an unconditional branch to itself.
#include <set>

#include "toolchain/objects/image.hpp"

namespace machine {

enum class ProgramEnd : std::uint8_t { none, idle, halt };

/// The kind of end that the word at `pc` may be.
ProgramEnd program_end(toolchain::Word word, toolchain::Address pc);

/// The addresses of all words of an image that may be an end.
std::set<toolchain::Address> program_ends(const toolchain::Image& image);

}  // namespace machine
