#pragma once
/// What two chips that should be alike are compared by.
#include <cstdint>
#include <vector>

#include "c40/chip.hpp"

namespace c40 {

/// Of all words of RAM that are not 0, whatever areas they lie in.
std::uint64_t digest(const Memory& memory);
/// What a program or a debugger can see of a chip, but its RAM, as 64-bit numbers.
std::vector<std::uint64_t> snapshot(const Chip& chip);

}  // namespace c40
