#pragma once
#include <stdexcept>
#include <string_view>

#include "io/print.hpp"

namespace machine::debug {

/// A command that makes no sense: an unknown place, a condition that does not parse. The message says what would be
/// right; of the user's words, which it repeats, every byte is visible.
class DebugError : public std::invalid_argument {
 public:
  explicit DebugError(std::string_view message) : std::invalid_argument(io::printable(message)) {}
};

}  // namespace machine::debug
