#pragma once
/// Named bits of the chip's memory-mapped registers. One declaration serves the models, the inspection by name and the
/// page docs/peripherals.md.
#include <string_view>

#include "c40/values/types.hpp"

namespace c40 {

enum class FieldAccess : std::uint8_t { read_write, read_only, write_only };

/// Bits low .. low + width - 1 of a register.
struct Field {
  std::string_view name;
  std::uint8_t low = 0, width = 1;
  FieldAccess access = FieldAccess::read_write;
  std::string_view meaning;

  constexpr Word mask() const { return (width == 32 ? ~Word{0} : (Word{1} << width) - 1) << low; }
  constexpr Word of(Word word) const { return (word & mask()) >> low; }
  constexpr bool in(Word word) const { return of(word) != 0; }
  constexpr Word with(Word word, Word value) const { return (word & ~mask()) | (value << low & mask()); }
};

}  // namespace c40
