#pragma once
// The words of a command, and the format of times in answers; only for the console's own sources.
#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

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

inline constexpr std::string_view blanks = " \t";
inline bool is_blank(char c) { return blanks.find(c) != std::string_view::npos; }
inline bool is_quote(char c) { return c == '"' || c == '\''; }

/// Where a comment begins: at a # that begins a word, and stands in no quotes.
inline std::size_t comment_in(std::string_view text) {
  char quote = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool begins_word = i == 0 || is_blank(text[i - 1]);
    if (quote != 0)
      quote = text[i] == quote ? '\0' : quote;
    else if (begins_word && text[i] == '#')
      return i;
    else if (begins_word && is_quote(text[i]) && text.find(text[i], i + 1) != std::string_view::npos)
      quote = text[i];
  }
  return text.size();
}

inline std::string_view without_comment(std::string_view text) {
  return ascii::trimmed(text.substr(0, comment_in(text)));
}

/// The rest of a command.
struct Console::Words {
  std::string_view rest;

  bool empty() const { return peek().empty(); }
  std::string_view peek() const {
    const std::string_view text = ascii::trimmed(rest);
    return text.starts_with('#') ? std::string_view() : text.substr(0, text.find_first_of(blanks));
  }
  std::string_view next() {
    const std::string_view word = peek();
    rest = ascii::trimmed(rest);
    rest.remove_prefix(word.size());
    return word;
  }
  /// A word of which a part may be in quotes: "FILE:LINE" and "FILE":LINE, if the file's name has blanks.
  std::string place() {
    if (const std::string_view word = peek(); word.empty() || !is_quote(word.front())) return std::string(next());
    const std::string_view text = ascii::trimmed(rest);
    const std::size_t closing = text.find(text.front(), 1);
    if (closing == std::string_view::npos)
      throw machine::debug::DebugError(fmt::format("{}: a closing {} is expected", text, text.front()));
    rest = text.substr(closing + 1);
    std::string place(text.substr(1, closing - 1));
    if (!rest.empty() && !is_blank(rest.front())) place += next();
    return place;
  }
  bool take(std::string_view word) {
    if (peek() != word) return false;
    next();
    return true;
  }
  std::string all() { return std::string(without_comment(std::exchange(rest, {}))); }
  /// All that is written, with what looks like a comment.
  std::string_view text() { return ascii::trimmed(std::exchange(rest, {})); }
  void end() const {
    if (!empty())
      throw machine::debug::DebugError(
          fmt::format("\"{}\": the end of the command is expected here", without_comment(rest)));
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
