#pragma once
// The words of a command, and the format of times in answers; only for the console's own sources.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

#include "debugger/console.hpp"
#include "isa/ascii.hpp"

namespace debugger {

inline std::string seconds(machine::Time time) {
  return fmt::format("{:.9f} s", static_cast<double>(time.count()) * 1e-12);
}

/// The length of the byte order mark that editors put before UTF-8.
inline std::size_t mark_of_utf8(std::string_view line) {
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  return line.starts_with(mark) ? mark.size() : 0;
}

/// The rest of a command.
struct Console::Words {
  std::string_view rest;

  bool empty() const { return ascii::trimmed(rest).empty(); }
  std::string_view next() {
    rest = ascii::trimmed(rest);
    const std::size_t end = std::min(rest.find_first_of(" \t"), rest.size());
    const std::string_view word = rest.substr(0, end);
    rest = ascii::trimmed(rest.substr(end));
    return word;
  }
  std::string_view peek() const {
    const std::string_view text = ascii::trimmed(rest);
    return text.substr(0, std::min(text.find_first_of(" \t"), text.size()));
  }
  bool take(std::string_view word) {
    if (peek() != word) return false;
    next();
    return true;
  }
  std::string all() {
    std::string text(ascii::trimmed(rest));
    rest = {};
    return text;
  }
  void end() const {
    if (!empty())
      throw machine::debug::DebugError(
          fmt::format("\"{}\": the end of the command is expected here", ascii::trimmed(rest)));
  }
  std::uint64_t count(std::string_view what) {
    const std::string_view word = next();
    const auto value = ascii::number<std::uint64_t>(word);
    if (!value || word.size() > 12)
      throw machine::debug::DebugError(
          fmt::format("{}: \"{}\" is not possible; an integer of at least 0 is expected", what, word));
    return *value;
  }
};

}  // namespace debugger
