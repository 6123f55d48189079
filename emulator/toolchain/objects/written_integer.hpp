#pragma once
// Whole numbers as a user writes them: 300000h, 0x300000 or decimal.
#include <cstdint>
#include <optional>
#include <string_view>

#include "isa/ascii.hpp"

namespace toolchain {

/// \returns nothing if the text is none, or does not fit in 64 bits
inline std::optional<std::uint64_t> written_integer(std::string_view text) {
  int base = 10;
  if (text.starts_with("0x") || text.starts_with("0X"))
    text.remove_prefix(2), base = 16;
  else if (text.ends_with('h') || text.ends_with('H'))
    text.remove_suffix(1), base = 16;
  return ascii::number<std::uint64_t>(text, base);
}

}  // namespace toolchain
