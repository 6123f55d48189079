#pragma once
/// A chip's state as a file, and back.
#include <string>
#include <string_view>

#include "c40/chip.hpp"

namespace c40 {

/// What two boards must have in common for a chip to go on upon the one as on the other.
std::string key_of(const Board& board);

/// The state, with the board that it is of, sealed (state/file.hpp).
std::string sealed(const Chip& chip);

/// The chip is as it was when the file was made. Listeners, breakpoints and links stay.
/// \throws state::StateError for a damaged file, or one of another board or version; then nothing has changed
void restore(Chip& chip, std::string_view file);

}  // namespace c40
