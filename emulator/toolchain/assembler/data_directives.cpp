// Directives that put words into sections.
#include <fmt/format.h>

#include "toolchain/assembler/reader.hpp"

namespace toolchain {

/// Numbers and strings, one word for each number and each character. Numbers of fewer than 32 bits are extended with 0.
WordItem Reader::numbers(Statement& s, unsigned bits) {
  if (!s.label.empty()) define_label(s);
  WordItem item;
  Parser& p = s.parser;
  do {
    p.skip_blanks();
    const std::size_t offset = p.offset();
    const auto constant = [&](std::int64_t value) {
      item.values.push_back({Expression::Kind::constant, Value::of(value), {}, {}, offset});
    };
    if (p.peek() == '"') {
      for (const char c : p.quoted()) constant(static_cast<unsigned char>(c));
    } else if (bits == 32) {
      item.values.push_back(p.expression());
    } else {
      const std::int64_t value = known_number(p, "the value");
      if (value < -(std::int64_t{1} << (bits - 1)) || value >= std::int64_t{1} << bits)
        throw LineError{offset, fmt::format("{} does not fit in {} bits", value, bits)};
      constant(value & ((std::int64_t{1} << bits) - 1));
    }
  } while (p.accept(","));
  p.expect_end();
  return item;
}

void Reader::directive_word(Statement& s) {
  WordItem item = numbers(s, 32);
  program_.add(s.line, s.operation_offset, std::move(item));
}

void Reader::directive_byte(Statement& s) {
  WordItem item = numbers(s, 8);
  program_.add(s.line, s.operation_offset, std::move(item));
}

void Reader::directive_half_word(Statement& s) {
  WordItem item = numbers(s, 16);
  program_.add(s.line, s.operation_offset, std::move(item));
}

/// `.field value[,bits]`: the next bits of the present word, from bit 0 up. A field that does not fit starts a new
/// word.
void Reader::directive_field(Statement& s) {
  Parser& p = s.parser;
  p.skip_blanks();
  const std::size_t offset = p.offset();
  Expression value = p.expression();
  const Address bits = p.accept(",") ? known_size(p, "the number of bits") : 32;
  p.expect_end();
  if (bits < 1 || bits > 32) throw LineError{offset, "a field has 1 to 32 bits"};
  if (bits < 32) {
    const Value known = evaluate(value, program_);
    if (known.is_real() || !known.is_absolute())
      throw LineError{offset, "a field of less than 32 bits takes a number that is known here"};
    if (known.integer < -(std::int64_t{1} << (bits - 1)) || known.integer >= std::int64_t{1} << bits)
      throw LineError{offset, fmt::format("{} does not fit in {} bits", known.integer, bits)};
    value = {Expression::Kind::constant, Value::of(known.integer & ((std::int64_t{1} << bits) - 1)), {}, {}, offset};
  }
  if (!s.label.empty()) program_.define(s.label, program_.field_place(bits), s.line, s.label_offset);
  program_.add_field(s.line, s.operation_offset, std::move(value), bits);
}

void Reader::floats(Statement& s, FloatItem::Format format) {
  if (!s.label.empty()) define_label(s);
  FloatItem item{s.parser.expression_list(), format};
  s.parser.expect_end();
  program_.add(s.line, s.operation_offset, std::move(item));
}

void Reader::directive_float(Statement& s) { floats(s, FloatItem::Format::single); }
void Reader::directive_ieee(Statement& s) { floats(s, FloatItem::Format::ieee); }
void Reader::directive_long_double(Statement& s) { floats(s, FloatItem::Format::extended); }

void Reader::directive_string(Statement& s) { packed_strings(s, false); }
void Reader::directive_asciz(Statement& s) { packed_strings(s, true); }

/// Four characters per word, the first in bits 7 to 0; the last word is filled with zeros.
void Reader::packed_strings(Statement& s, bool terminated) {
  if (!s.label.empty()) define_label(s);
  std::string bytes;
  do {
    s.parser.skip_blanks();
    if (s.parser.peek() != '"') {
      const std::size_t offset = s.parser.offset();
      const std::int64_t number = known_number(s.parser, "a character's number");
      if (number < -128 || number > 255) throw LineError{offset, fmt::format("{} does not fit in 8 bits", number)};
      bytes += static_cast<char>(number);
      continue;
    }
    bytes += s.parser.quoted();
    if (terminated) bytes += '\0';
  } while (s.parser.accept(","));
  s.parser.expect_end();
  WordItem item;
  for (std::size_t i = 0; i < bytes.size(); i += 4) {
    Word word = 0;
    for (std::size_t k = 0; k < 4 && i + k < bytes.size(); ++k)
      word |= Word{static_cast<unsigned char>(bytes[i + k])} << (8 * k);
    item.values.push_back({Expression::Kind::constant, Value::of(std::int64_t{word}), {}, {}, s.operation_offset});
  }
  program_.add(s.line, s.operation_offset, std::move(item));
}

void Reader::directive_space(Statement& s) {
  if (!s.label.empty()) define_label(s);
  const Address words = known_size(s.parser, "the number of words");
  s.parser.expect_end();
  program_.add(s.line, s.operation_offset, FillItem{words, 0});
}

/// As .space, but the label is the address of the last word.
void Reader::directive_space_end(Statement& s) {
  const Address words = known_size(s.parser, "the number of words");
  s.parser.expect_end();
  program_.add(s.line, s.operation_offset, FillItem{words, 0});
  Value last = program_.here();
  --last.integer;
  if (!s.label.empty()) program_.define(s.label, last, s.line, s.label_offset);
}

}  // namespace toolchain
