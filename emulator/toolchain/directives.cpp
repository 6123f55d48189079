// The directives of the assembler's reader.
#include <fmt/format.h>

#include "toolchain/reader.hpp"

namespace toolchain {

const std::map<std::string, Reader::Directive, std::less<>>& Reader::directives() {
  static const std::map<std::string, Directive, std::less<>> table{
      {".text", &Reader::directive_section_text}, {".data", &Reader::directive_section_data},
      {".bss", &Reader::directive_bss},           {".sect", &Reader::directive_sect},
      {".section", &Reader::directive_sect},      {".usect", &Reader::directive_usect},
      {".word", &Reader::directive_word},         {".int", &Reader::directive_word},
      {".long", &Reader::directive_word},         {".byte", &Reader::directive_byte},
      {".float", &Reader::directive_float},       {".single", &Reader::directive_float},
      {".string", &Reader::directive_string},     {".ascii", &Reader::directive_string},
      {".asciz", &Reader::directive_asciz},       {".cstring", &Reader::directive_asciz},
      {".space", &Reader::directive_space},       {".align", &Reader::directive_align},
      {".set", &Reader::directive_set},           {".equ", &Reader::directive_set},
      {".include", &Reader::directive_include},   {".copy", &Reader::directive_include},
      {".global", &Reader::directive_global},     {".globl", &Reader::directive_global},
      {".ref", &Reader::directive_global},        {".def", &Reader::directive_def},
      {".macro", &Reader::start_macro},           {".endm", &Reader::directive_stray},
      {".rept", &Reader::start_repeat},           {".loop", &Reader::start_repeat},
      {".endr", &Reader::directive_stray},        {".endloop", &Reader::directive_stray},
      {".end", &Reader::directive_end},           {".emsg", &Reader::directive_error},
      {".error", &Reader::directive_error},       {".title", &Reader::directive_nothing},
      {".version", &Reader::directive_nothing},   {".file", &Reader::directive_nothing},
      {".ident", &Reader::directive_nothing},     {".page", &Reader::directive_nothing},
      {".list", &Reader::directive_nothing},      {".nolist", &Reader::directive_nothing},
      {".mlist", &Reader::directive_nothing},     {".mnolist", &Reader::directive_nothing},
      {".length", &Reader::directive_nothing},    {".width", &Reader::directive_nothing},
  };
  return table;
}

std::int64_t Reader::known_number(Parser& parser, std::string_view what) {
  parser.skip_blanks();
  const std::size_t offset = parser.offset();
  const Value value = evaluate(parser.expression(), program_);
  if (value.is_real() || !value.is_absolute())
    throw LineError{offset, fmt::format("{} must be an integer that is known here", what)};
  return value.integer;
}

Address Reader::known_size(Parser& parser, std::string_view what) {
  parser.skip_blanks();
  const std::size_t offset = parser.offset();
  const std::int64_t size = known_number(parser, what);
  if (size < 0 || size > 0xFFFFFFFF) throw LineError{offset, fmt::format("{} cannot be {}", what, size)};
  return static_cast<Address>(size);
}

/// The symbol that a directive defines: its label, or its first operand before a comma.
std::string Reader::symbol_name(Statement& s) {
  if (!s.label.empty()) return s.label;
  s.parser.skip_blanks();
  s.label_offset = s.parser.offset();
  std::string name = s.parser.required_identifier("a symbol");
  s.parser.expect(",");
  return name;
}

void Reader::directive_section_text(Statement& s) {
  s.parser.expect_end();
  program_.select(program_.section(".text", Program::Load::loaded, s.operation_offset));
  if (!s.label.empty()) define_label(s);
}

void Reader::directive_section_data(Statement& s) {
  s.parser.expect_end();
  program_.select(program_.section(".data", Program::Load::loaded, s.operation_offset));
  if (!s.label.empty()) define_label(s);
}

void Reader::directive_sect(Statement& s) {
  const std::size_t offset = s.parser.offset();
  const std::string name = s.parser.name_or_quoted("the section's name");
  s.parser.expect_end();
  const auto load = name == ".bss" ? Program::Load::reserved : Program::Load::loaded;
  program_.select(program_.section(name, load, offset));
  if (!s.label.empty()) define_label(s);
}

/// `.bss name,size[,alignment]` reserves; `.bss` alone makes it the current section.
void Reader::directive_bss(Statement& s) {
  Parser& p = s.parser;
  const int bss = program_.section(".bss", Program::Load::reserved, s.operation_offset);
  if (p.at_end()) {
    program_.select(bss);
    if (!s.label.empty()) define_label(s);
    return;
  }
  p.skip_blanks();
  const std::size_t offset = p.offset();
  const std::string name = p.required_identifier("a symbol");
  p.expect(",");
  const Address size = known_size(p, "the size");
  const Address alignment = p.accept(",") ? known_size(p, "the alignment") : 1;
  p.expect_end();
  program_.define(name, program_.reserve(bss, size, alignment, offset), s.line, offset);
}

/// `name .usect "section",size[,alignment]`
void Reader::directive_usect(Statement& s) {
  Parser& p = s.parser;
  if (s.label.empty()) throw LineError{s.operation_offset, ".usect needs a label: name .usect \"section\",size"};
  const std::size_t offset = p.offset();
  const std::string section_name = p.name_or_quoted("the section's name");
  p.expect(",");
  const Address size = known_size(p, "the size");
  const Address alignment = p.accept(",") ? known_size(p, "the alignment") : 1;
  p.expect_end();
  const int section = program_.section(section_name, Program::Load::reserved, offset);
  program_.define(s.label, program_.reserve(section, size, alignment, offset), s.line, s.label_offset);
}

void Reader::directive_word(Statement& s) {
  if (!s.label.empty()) define_label(s);
  WordItem item{s.parser.expression_list()};
  s.parser.expect_end();
  program_.add(s.line, s.operation_offset, std::move(item));
}

/// One character or number of 8 bits per word.
void Reader::directive_byte(Statement& s) {
  if (!s.label.empty()) define_label(s);
  WordItem item;
  do {
    s.parser.skip_blanks();
    const std::size_t offset = s.parser.offset();
    const std::int64_t value = known_number(s.parser, "a byte");
    if (value < -128 || value > 255) throw LineError{offset, fmt::format("{} does not fit in 8 bits", value)};
    item.values.push_back({Expression::Kind::constant, Value::of(value & 255), {}, {}, offset});
  } while (s.parser.accept(","));
  s.parser.expect_end();
  program_.add(s.line, s.operation_offset, std::move(item));
}

void Reader::directive_float(Statement& s) {
  if (!s.label.empty()) define_label(s);
  FloatItem item{s.parser.expression_list()};
  s.parser.expect_end();
  program_.add(s.line, s.operation_offset, std::move(item));
}

void Reader::directive_string(Statement& s) { strings(s, false); }
void Reader::directive_asciz(Statement& s) { strings(s, true); }

/// A C40 character is a word.
void Reader::strings(Statement& s, bool terminated) {
  if (!s.label.empty()) define_label(s);
  WordItem item;
  const auto append = [&](std::int64_t code, std::size_t offset) {
    item.values.push_back({Expression::Kind::constant, Value::of(code), {}, {}, offset});
  };
  do {
    s.parser.skip_blanks();
    const std::size_t offset = s.parser.offset();
    if (s.parser.peek() != '"') {
      append(known_number(s.parser, "a character's number") & 255, offset);
      continue;
    }
    for (const char c : s.parser.quoted()) append(static_cast<unsigned char>(c), offset);
    if (terminated) append(0, offset);
  } while (s.parser.accept(","));
  s.parser.expect_end();
  program_.add(s.line, s.operation_offset, std::move(item));
}

void Reader::directive_space(Statement& s) {
  if (!s.label.empty()) define_label(s);
  const Address words = known_size(s.parser, "the number of words");
  s.parser.expect_end();
  program_.add(s.line, s.operation_offset, FillItem{words, 0});
}

/// Without an operand: 32 words, a cache segment.
void Reader::directive_align(Statement& s) {
  const Address words = s.parser.at_end() ? 32 : known_size(s.parser, "the alignment");
  s.parser.expect_end();
  program_.align(s.line, s.operation_offset, words);
  if (!s.label.empty()) define_label(s);
}

void Reader::directive_set(Statement& s) {
  const std::string name = symbol_name(s);
  Expression expression = s.parser.expression();
  s.parser.expect_end();
  program_.define(name, std::move(expression), s.line, s.label_offset);
}

void Reader::directive_include(Statement& s) {
  if (!s.label.empty()) define_label(s);
  s.parser.skip_blanks();
  const std::size_t offset = s.parser.offset();
  const std::filesystem::path name = s.parser.name_or_quoted("the file's name");
  s.parser.expect_end();
  std::vector<std::filesystem::path> places{directory_ / name};
  for (const auto& directory : options_.include_dirs) places.push_back(directory / name);
  std::string tried;
  for (const auto& place : places) {
    std::error_code error;
    if (!std::filesystem::exists(place, error)) {
      tried += (tried.empty() ? "" : ", ") + place.string();
      continue;
    }
    try {
      return read_file(place);
    } catch (const LineError& failure) {
      throw LineError{offset, failure.message};
    }
  }
  throw LineError{offset, fmt::format("no file '{}' (looked for {})", name.string(), tried)};
}

void Reader::directive_global(Statement& s) {
  do {
    s.parser.skip_blanks();
    const std::size_t offset = s.parser.offset();
    program_.declare_global(s.parser.required_identifier("a symbol"), false, s.line, offset);
  } while (s.parser.accept(","));
  s.parser.expect_end();
}

void Reader::directive_def(Statement& s) {
  do {
    s.parser.skip_blanks();
    const std::size_t offset = s.parser.offset();
    program_.declare_global(s.parser.required_identifier("a symbol"), true, s.line, offset);
  } while (s.parser.accept(","));
  s.parser.expect_end();
}

void Reader::directive_end(Statement&) { ended_ = true; }

void Reader::directive_error(Statement& s) {
  throw LineError{s.operation_offset,
                  s.parser.at_end() ? "error asked for by the source" : s.parser.name_or_quoted("a message")};
}

void Reader::directive_nothing(Statement&) {}

void Reader::directive_stray(Statement& s) {
  throw LineError{s.operation_offset, fmt::format("'{}' closes nothing", s.operation)};
}

}  // namespace toolchain
