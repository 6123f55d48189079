#include "io/print.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>

namespace io {
namespace {

int lost = 0;

unsigned char byte(char c) { return static_cast<unsigned char>(c); }

/// Bytes of the character that begins here; 0 if it is not UTF-8 (RFC 3629: shortest form, no surrogates, up to
/// 10FFFFh).
std::size_t length_of(std::string_view text) {
  const unsigned char first = byte(text[0]);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < length) return 0;
  std::uint32_t code = first & (0xFFU >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(text[i]) & 0xC0U) != 0x80) return 0;
    code = code << 6 | (byte(text[i]) & 0x3FU);
  }
  constexpr std::uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
  if (code < least[length] || code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF)) return 0;
  return length;
}

bool is_control(std::string_view character) {
  const unsigned char first = byte(character[0]);
  if (character.size() == 1) return (first < 0x20 && first != '\n' && first != '\t') || first == 0x7F;
  return character.size() == 2 && first == 0xC2 && byte(character[1]) < 0xA0;  // U+0080 to U+009F
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = length_of(text);
    const std::string_view character = text.substr(0, std::max<std::size_t>(1, length));
    if (length == 0 || is_control(character)) {
      for (const char c : character) out += fmt::format("\\x{:02X}", byte(c));
    } else {
      out += character;
    }
    text.remove_prefix(character.size());
  }
  return out;
}

std::string exception_text(std::string_view text) {
  std::string out;
  for (const char c : text)
    if (c == '\0')
      out += "\\x00";
    else
      out += c;
  return out;
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = length_of(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

void say(std::FILE* to, std::string_view text) {
  const std::string shown = printable(text);
  errno = 0;
  if (std::fwrite(shown.data(), 1, shown.size(), to) != shown.size() && to == stdout && lost == 0)
    lost = errno == 0 ? EIO : errno;
}

int lost_in_saying() { return lost; }

}  // namespace io
