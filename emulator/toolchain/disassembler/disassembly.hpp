#pragma once
// Programs and objects as text.
#include <string>

#include "toolchain/objects/image.hpp"
#include "toolchain/objects/object.hpp"

namespace toolchain {

/// Address, word and instruction of every loaded word, with the program's labels. A section of data is shown as words.
/// Of 8 or more equal words, only the first is shown.
std::string disassembly(const Image& image);

/// The same for an object, with its relocations as comments.
std::string disassembly(const Object& object);

/// A source that assembles to the same words: sections, labels (new ones where branch targets have none), instructions,
/// and .word for words that are not instructions and for sections of data. Its first lines name the options.
std::string source_of(const Image& image);

}  // namespace toolchain
