#pragma once
/// Values with which two chips that should be equal are compared.
#include <cstdint>
#include <vector>

#include "c40/chip/chip.hpp"

namespace c40 {

/// A digest of all words of RAM that are not 0, in any area.
std::uint64_t digest(const Memory& memory);
/// Everything of a chip that a program or a debugger can see, except its RAM, as 64-bit numbers.
std::vector<std::uint64_t> snapshot(const Chip& chip);

}  // namespace c40
