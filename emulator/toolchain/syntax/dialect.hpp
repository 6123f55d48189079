#pragma once
// The assembler for which a source was written. TI's and GNU's read some lines differently (docs/assembler.md,
// Dialects).
#include <cstdint>
#include <optional>
#include <string_view>

namespace toolchain {

enum class Dialect : std::uint8_t { ti, gnu };

constexpr std::string_view name(Dialect dialect) { return dialect == Dialect::ti ? "ti" : "gnu"; }

/// "ti" or "gnu".
constexpr std::optional<Dialect> dialect_named(std::string_view text) {
  for (const Dialect dialect : {Dialect::ti, Dialect::gnu})
    if (text == name(dialect)) return dialect;
  return std::nullopt;
}

}  // namespace toolchain
