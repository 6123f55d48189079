#pragma once
// How a program says that it has ended: IDLE, or an unconditional branch to itself.
#include <set>

#include "toolchain/objects/image.hpp"

namespace machine {

enum class ProgramEnd : std::uint8_t { none, idle, halt };

/// What the word at `pc` may be the end of.
ProgramEnd program_end(toolchain::Word word, toolchain::Address pc);

/// The addresses of all words of an image that may be an end.
std::set<toolchain::Address> program_ends(const toolchain::Image& image);

}  // namespace machine
