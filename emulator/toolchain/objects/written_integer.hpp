#pragma once
// Whole numbers as a user writes them: 300000h, 0x300000 or decimal.
#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>

namespace toolchain {

/// \returns nothing if the text is none, or does not fit in 64 bits
inline std::optional<std::uint64_t> written_integer(std::string_view text) {
  int base = 10;
  if (text.starts_with("0x") || text.starts_with("0X"))
    text.remove_prefix(2), base = 16;
  else if (text.ends_with('h') || text.ends_with('H'))
    text.remove_suffix(1), base = 16;
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

}  // namespace toolchain
