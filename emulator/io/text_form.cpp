#include "io/text_form.hpp"

#include <algorithm>

namespace io {

std::string_view wide_form(std::string_view text) {
  using namespace std::string_view_literals;
  if (text.starts_with("\xFF\xFE\0\0"sv) || text.starts_with("\0\0\xFE\xFF"sv)) return "UTF-32";
  if (text.starts_with("\xFF\xFE"sv) || text.starts_with("\xFE\xFF"sv)) return "UTF-16";
  // Without a mark: the ASCII characters that a source begins with have a byte 0 each.
  constexpr std::size_t looked_at = 16;
  const std::string_view first = text.substr(0, std::min(text.size(), looked_at) & ~std::size_t{3});
  if (first.empty()) return {};
  const auto zeros = std::ranges::count(first, '\0');
  const auto each = [&](std::size_t from) {
    for (std::size_t i = from; i < first.size(); i += 2)
      if (first[i] != '\0' || first[i ^ 1] == '\0') return false;
    return true;
  };
  if (each(0) || each(1)) return "UTF-16";
  return static_cast<std::size_t>(zeros) * 4 == first.size() * 3 ? "UTF-32" : "";
}

std::string wide_form_problem(std::string_view text) {
  const std::string_view form = wide_form(text);
  if (form.empty()) return {};
  return fmt::format("the text is in {}; a text in ASCII, Latin-1 or UTF-8 is expected", form);
}

std::string_view without_dos_end(std::string_view text) {
  const std::size_t end = text.find('\x1A');
  if (end == std::string_view::npos) return text;
  constexpr std::string_view nothing("\x1A\0 \t\r\n", 6);
  return text.find_first_not_of(nothing, end) == std::string_view::npos ? text.substr(0, end) : text;
}

std::string_view without_mark(std::string_view text) {
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  return text.starts_with(mark) ? text.substr(mark.size()) : text;
}

}  // namespace io
