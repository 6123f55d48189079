#include "cmrc/configuration/rows/value.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/nearest.hpp"

namespace cmrc {
namespace {

std::string in_quotes(std::string_view word) {
  std::string text = "\"";
  for (std::size_t i = 0; i < word.size(); ++i) {
    const char c = word[i];
    const auto byte = static_cast<unsigned char>(c);
    const unsigned next = i + 1 < word.size() ? static_cast<unsigned char>(word[i + 1]) : 0;
    if (byte == 0xC2 && next >= 0x80 && next < 0xA0)
      text += fmt::format("\\u{:04x}", next), ++i;  // U+0080 to U+009F are control characters, too
    else if (c == '"' || c == '\\')
      text += fmt::format("\\{}", c);
    else if (byte < 0x20 || byte == 0x7F)
      text += fmt::format("\\u{:04x}", byte);
    else
      text += c;
  }
  return text + '"';
}

}  // namespace

std::string Origin::text() const { return line > 0 ? fmt::format("{}:{}:{}", name, line, column) : name; }

void refuse(const Origin& origin, std::string_view key, std::string_view what, std::string_view right) {
  const std::string at = origin.text();
  throw ConfigError(
      fmt::format("{}{}{}{}{}; {}", at, at.empty() ? "" : ": ", key, key.empty() ? "" : ": ", what, right));
}

void ConfigErrors::finish() const {
  if (found_.empty()) return;
  std::vector<std::string_view> lines;
  for (const auto& [place, what] : found_) lines.push_back(what);
  if (found_.size() == most) lines.push_back("there may be more errors; the file was not read further");
  throw ConfigError(fmt::format("{}", fmt::join(lines, "\n")));
}

std::string show(const Value& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return fmt::format("{}", *integer);
  if (const auto* word = std::get_if<std::string>(&value)) return in_quotes(*word);
  std::string text = fmt::format("{}", std::get<double>(value));
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string_view noun(const Value& value) {
  static constexpr std::string_view names[] = {"a boolean", "an integer", "a number", "a string"};
  return names[value.index()];
}

std::string quoted_list(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    text += fmt::format("{}\"{}\"", i == 0 ? "" : i + 1 == words.size() ? " or " : ", ", words[i]);
  }
  return text;
}

std::string one_expected(std::string_view given, const std::vector<std::string>& words) {
  return quoted_list(words) + " is expected" + io::did_you_mean(given, words);
}

}  // namespace cmrc
