#pragma once
// Programs and objects as text.
#include <string>

#include "toolchain/objects/image.hpp"
#include "toolchain/objects/object.hpp"

namespace toolchain {

/// Address, word and instruction of every loaded word, with the program's labels. A section of data is shown as words;
/// of 8 or more equal words the first alone.
std::string disassembly(const Image& image);

/// The same of an object, with its relocations as comments.
std::string disassembly(const Object& object);

/// A source that assembles to the same words: sections, labels (made up where branches go to places without one),
/// instructions, and .word for what is none and for sections of data. Its first lines say with which options.
std::string source_of(const Image& image);

}  // namespace toolchain
