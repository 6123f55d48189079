#pragma once
// What assembles but does not run as it reads on a C40 (c40-isa.md 8.2 to 8.4).
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "isa/types.hpp"

namespace toolchain {

struct Finding {
  std::size_t index = 0;  ///< Of the word.
  std::string message;
};

/// Looks at consecutive words of code: program control in the three slots of a delayed branch, behind RPTS, and at the
/// end of a repeated block whose RPTB stands in these words too. `address` is that of the first word.
std::vector<Finding> check_code(std::span<const isa::Word> words, isa::Address address, isa::Cpu cpu);

}  // namespace toolchain
