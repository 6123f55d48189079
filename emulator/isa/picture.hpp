#pragma once
// A bit picture draws an encoding, bit 31 first: '0' and '1' are fixed bits, a letter belongs to the field of that
// name, spaces have no meaning. The picture gives mask, match and field positions at compile time.
#include <array>
#include <cstdint>
#include <string_view>

#include "isa/types.hpp"

namespace isa {

struct Field {
  std::uint8_t shift = 0;
  std::uint8_t width = 0;  ///< 0: the encoding has no such field.
  constexpr Word get(Word word) const { return (word >> shift) & ((Word{1} << width) - 1); }
  constexpr Word put(Word value) const { return (value & ((Word{1} << width) - 1)) << shift; }
  constexpr explicit operator bool() const { return width != 0; }
};

struct Picture {
  Word mask = 0;   ///< 1 where the encoding fixes a bit.
  Word match = 0;  ///< The fixed bits.
  std::array<Field, 26> fields{};

  constexpr const Field& field(char letter) const { return fields[static_cast<std::size_t>(letter - 'a')]; }
};

/// Not a constant expression (so a compile error in the table) unless the text draws 32 bits with contiguous fields.
constexpr Picture parse_picture(std::string_view text) {
  Picture picture;
  int bit = 31;
  for (const char c : text) {
    if (c == ' ') continue;
    if (bit < 0) throw "a bit picture has more than 32 bits";
    if (c == '0' || c == '1') {
      picture.mask |= Word{1} << bit;
      if (c == '1') picture.match |= Word{1} << bit;
    } else if (c >= 'a' && c <= 'z') {
      Field& field = picture.fields[static_cast<std::size_t>(c - 'a')];
      if (field.width != 0 && field.shift != bit + 1) throw "a field of a bit picture is not contiguous";
      field.shift = static_cast<std::uint8_t>(bit);
      ++field.width;
    } else {
      throw "a bit picture holds 0, 1, lower-case letters and spaces";
    }
    --bit;
  }
  if (bit != -1) throw "a bit picture has fewer than 32 bits";
  return picture;
}

}  // namespace isa
