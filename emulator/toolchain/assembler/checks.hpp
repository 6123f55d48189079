#pragma once
// Code that assembles, but that a C40 does not run as written (c40-isa.md 8.2 to 8.4).
#include <span>
#include <string>
#include <vector>

#include "isa/word.hpp"

namespace toolchain {

struct Finding {
  std::size_t index = 0;  ///< Of the word.
  std::string message;
};

/// Checks consecutive words of code: program control in the three slots of a delayed branch, after RPTS, and at the end
/// of a repeated block whose RPTB is among these words. `address` is the address of the first word.
std::vector<Finding> check_code(std::span<const isa::Word> words, isa::Address address, isa::Cpu cpu);

}  // namespace toolchain
