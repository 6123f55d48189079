#pragma once
#include <stdexcept>

namespace machine::debug {

/// A command that makes no sense: an unknown place, a condition that does not parse. The message says what would be
/// right.
class DebugError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

}  // namespace machine::debug
