// Numbers and characters in the source text.
#include <fmt/format.h>

#include "isa/ascii.hpp"
#include "toolchain/syntax/diagnostics.hpp"
#include "toolchain/syntax/parser.hpp"

namespace toolchain {
namespace {

std::optional<std::int64_t> integer_in_base(std::string_view digits, int base) {
  return digits.starts_with('-') ? std::nullopt : ascii::number<std::int64_t>(digits, base);
}

bool all_of(std::string_view text, std::string_view allowed) {
  return text.find_first_not_of(allowed) == std::string_view::npos;
}

constexpr std::string_view hex_digits = "0123456789abcdefABCDEF";

struct Digits {
  std::string_view digits;
  int base = 10;
};

/// TI's and GNU's forms of integers: 0FFh 101b 17q 0xFF 0b101 255. A leading 0 has no meaning: 017 is 17 (ruling 33).
Digits digits_of(std::string_view text) {
  const char first = text[0], last = lower(text.back());
  const auto body = text.substr(0, text.size() - 1);
  if (text.size() > 2 && first == '0' && (text[1] == 'x' || text[1] == 'X')) return {text.substr(2), 16};
  if (last == 'h' && all_of(body, hex_digits)) return {body, 16};
  if (last == 'b' && !body.empty() && all_of(body, "01")) return {body, 2};
  if (last == 'q' && all_of(body, "01234567")) return {body, 8};
  if (text.size() > 2 && first == '0' && (text[1] == 'b' || text[1] == 'B')) return {text.substr(2), 2};
  return {text, 10};
}

std::optional<std::int64_t> integer_literal(std::string_view text) {
  const Digits number = digits_of(text);
  return integer_in_base(number.digits, number.base);
}

}  // namespace

ConstantKind constant_kind(std::string_view text) {
  if (text.empty()) return ConstantKind::none;
  if (character_constant(text) == text.size()) return ConstantKind::character;
  if (!is_digit(text[0]) || !integer_literal(text)) return ConstantKind::none;
  switch (digits_of(text).base) {
    case 2: return ConstantKind::binary;
    case 8: return ConstantKind::octal;
    case 16: return ConstantKind::hexadecimal;
    default: return ConstantKind::decimal;
  }
}

std::size_t character_constant(std::string_view text) {
  constexpr std::size_t most = 4;
  if (text.starts_with("''''")) return 4;
  if (text.empty() || text[0] != '\'') return 0;
  const std::size_t end = text.find('\'', 1);
  return end == std::string_view::npos || end < 2 || end > most + 1 ? 0 : end + 1;
}

/// One to four characters, packed as .string packs them: the first in bits 7 to 0.
Expression Parser::character() {
  const std::size_t at = position_, length = character_constant(rest());
  if (length == 0)
    throw LineError{at, "a character constant is one to four characters between single quotes ('''' is a quote)"};
  const std::string_view inside = starts_with("''''") ? std::string_view("'") : text_.substr(at + 1, length - 2);
  std::int64_t value = 0;
  for (std::size_t i = 0; i < inside.size(); ++i) value |= std::int64_t{static_cast<unsigned char>(inside[i])} << 8 * i;
  position_ += length;
  return Expression{Expression::Kind::constant, Value::of(value), {}, {}, at};
}

/// Earlier assemblers read this number as octal.
void Parser::warn_of_octal(std::string_view word, std::size_t at) const {
  if (context_.warnings == nullptr || word.size() < 2 || word[0] != '0' || !all_of(word, "01234567")) return;
  const auto octal = integer_in_base(word, 8), decimal = integer_in_base(word, 10);
  if (octal && octal != decimal)
    context_.warnings->push_back({at, fmt::format("{0} is decimal here. The octal number is {0}q", word)});
}

/// GNU's 0f1.5, unless it is a hexadecimal number.
std::optional<Real> Parser::prefixed_float() {
  if (peek() != '0' || lower(text_.substr(position_, 2)) != "0f") return std::nullopt;
  std::size_t end = position_ + 2;
  while (end < text_.size() &&
         (is_identifier(text_[end]) || ((text_[end] == '-' || text_[end] == '+') &&
                                        (end == position_ + 2 || lower(text_.substr(end - 1, 1)) == "e"))))
    ++end;
  const auto value = parse_real(text_.substr(position_ + 2, end - position_ - 2));
  if (value) position_ = end;
  return value;
}

Expression Parser::number() {
  const std::size_t at = position_;
  std::size_t end = position_;
  while (end < text_.size() && ascii::is_letter_or_digit(text_[end])) ++end;
  const auto word = text_.substr(at, end - at);
  if (const auto value = prefixed_float()) return Expression{Expression::Kind::constant, Value::of(*value), {}, {}, at};
  const bool point = end < text_.size() && text_[end] == '.';
  if (!point && !word.empty()) {
    if (const auto value = integer_literal(word)) {
      warn_of_octal(word, at);
      position_ = end;
      return Expression{Expression::Kind::constant, Value::of(*value), {}, {}, at};
    }
  }
  // A float: digits, point, digits, exponent.
  end = at;
  const auto digits = [&] {
    while (end < text_.size() && is_digit(text_[end])) ++end;
  };
  digits();
  bool is_float = false;
  if (end < text_.size() && text_[end] == '.') is_float = true, ++end, digits();
  if (end < text_.size() && (text_[end] == 'e' || text_[end] == 'E')) {
    std::size_t exponent = end + 1;
    if (exponent < text_.size() && (text_[exponent] == '+' || text_[exponent] == '-')) ++exponent;
    if (exponent < text_.size() && is_digit(text_[exponent])) is_float = true, end = exponent, digits();
  }
  const bool ends_cleanly = end >= text_.size() || !is_identifier(text_[end]);
  const auto value = is_float && ends_cleanly ? parse_real(text_.substr(at, end - at)) : std::nullopt;
  if (!value) {
    while (end < text_.size() && is_identifier(text_[end])) ++end;
    throw LineError{at, fmt::format("'{}' is not a number (255, 0FFh, 0xFF, 377q, 101b, 1.5, 2.5e-3, 'A')",
                                    text_.substr(at, end - at))};
  }
  position_ = end;
  return Expression{Expression::Kind::constant, Value::of(*value), {}, {}, at};
}

}  // namespace toolchain
