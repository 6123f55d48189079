#pragma once
// A program lacks a symbol that it must have.
#include <stdexcept>

namespace toolchain {

/// "the program has no symbol 'X'", from Image::symbol. An out_of_range, so that Python gets an IndexError.
class MissingSymbol : public std::out_of_range {
 public:
  using std::out_of_range::out_of_range;
};

}  // namespace toolchain
