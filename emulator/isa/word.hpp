#pragma once
// Words, addresses and processors, which every room needs; registers and conditions are in isa/types.hpp.
#include <cstdint>

namespace isa {

using Word = std::uint32_t;
using Address = std::uint32_t;  ///< Counts 32-bit words.

/// The processor for whose instructions a word is decoded. The emulator runs only the C40's.
enum class Cpu : std::uint8_t { c40, c3x };

}  // namespace isa
