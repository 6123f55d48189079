// What the directives for sections, symbols, files and messages do.
#include <fmt/format.h>

#include <algorithm>

#include "toolchain/assembler/reader.hpp"

namespace toolchain {

namespace {

/// The file, or one whose name differs only in upper and lower case: DOS does not distinguish them.
std::optional<std::filesystem::path> in_any_case(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::exists(path, error)) return path;
  const std::string wanted = lower(path.filename().string());
  const auto directory = path.parent_path().empty() ? std::filesystem::path(".") : path.parent_path();
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::directory_iterator(directory, error))
    if (lower(entry.path().filename().string()) == wanted)
      found.push_back(path.parent_path() / entry.path().filename());
  if (found.empty()) return std::nullopt;
  return *std::min_element(found.begin(), found.end());
}

}  // namespace

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

void Reader::select_section(Statement& s, const std::string& name, Program::Load load, std::size_t offset) {
  const int section = program_.section(name, load, offset);
  if (section != program_.current()) new_block();
  program_.select(section);
  if (!s.label.empty()) define_label(s);
}

void Reader::directive_section_text(Statement& s) {
  s.parser.expect_end();
  select_section(s, ".text", Program::Load::loaded, s.operation_offset);
}

void Reader::directive_section_data(Statement& s) {
  s.parser.expect_end();
  select_section(s, ".data", Program::Load::loaded, s.operation_offset);
}

void Reader::directive_section_const(Statement& s) {
  s.parser.expect_end();
  select_section(s, ".const", Program::Load::loaded, s.operation_offset);
}

void Reader::directive_sect(Statement& s) {
  const std::size_t offset = s.parser.offset();
  const std::string name = s.parser.name_or_quoted("the section's name");
  s.parser.expect_end();
  select_section(s, name, name == ".bss" ? Program::Load::reserved : Program::Load::loaded, offset);
}

/// The alignment that may follow a size.
Address Reader::alignment_of_reserved(Parser& p, int section) {
  if (!p.accept(",")) return 1;
  const Address alignment = known_size(p, "the alignment");
  if (alignment == 1) program_.block(section);
  return std::max(alignment, Address{1});
}

/// `.bss name,size[,alignment]` reserves; `.bss` alone makes it the current section. An alignment of 1 is TI's blocking
/// flag: words that fit into one page are not split over two.
void Reader::directive_bss(Statement& s) {
  Parser& p = s.parser;
  if (p.at_end()) return select_section(s, ".bss", Program::Load::reserved, s.operation_offset);
  place_label(s);  // of the present section: the operand names the words
  const int bss = program_.section(".bss", Program::Load::reserved, s.operation_offset);
  p.skip_blanks();
  const std::size_t offset = p.offset();
  const std::string name = p.required_identifier("a symbol");
  p.expect(",");
  const Address size = known_size(p, "the size");
  const Address alignment = alignment_of_reserved(p, bss);
  p.expect_end();
  program_.define(name, program_.reserve(bss, size, alignment, offset), s.line, offset);
}

/// `name .usect "section",size[,alignment]`
void Reader::directive_usect(Statement& s) {
  Parser& p = s.parser;
  const std::size_t offset = p.offset();
  const std::string section_name = p.name_or_quoted("the section's name");
  p.expect(",");
  p.skip_blanks();
  const std::size_t size_offset = p.offset();
  Address size = 0;
  if (const auto reg = reading_.dialect == Dialect::ti ? p.lone_register() : std::nullopt) {
    size = static_cast<Address>(*reg);
    parser_warnings_.push_back(
        {size_offset, fmt::format("{} is a register: its number, {}, is taken as the size; a number is expected",
                                  isa::name(*reg), size)});
  } else {
    size = known_size(p, "the size");
  }
  const int section = program_.section(section_name, Program::Load::reserved, offset);
  const Address alignment = alignment_of_reserved(p, section);
  p.expect_end();
  const Value place = program_.reserve(section, size, alignment, offset);
  if (!s.label.empty()) program_.define(s.label, place, s.line, s.label_offset);
}

void Reader::directive_label(Statement& s) {
  s.parser.skip_blanks();
  const std::size_t offset = s.parser.offset();
  const std::string name = s.parser.required_identifier("a symbol");
  s.parser.expect_end();
  program_.end_field();
  program_.define(name, program_.here(), s.line, offset);
}

void Reader::directive_newblock(Statement& s) {
  s.parser.expect_end();
  new_block();
}

/// `.version 40`. Branches and interrupt registers make the difference to C3x code, so there is a warning if the
/// version is not the processor for which the source is assembled.
void Reader::directive_version(Statement& s) {
  s.parser.skip_blanks();
  const std::size_t offset = s.parser.offset();
  const std::int64_t version = known_number(s.parser, "the processor's number");
  s.parser.expect_end();
  const bool is_c40 = version == 40 || version == 44;
  if (!is_c40 && (version < 30 || version > 33))
    throw LineError{offset, fmt::format("no processor has the number {}; 30 to 33, 40 and 44 are known here", version)};
  if (is_c40 == (options_.cpu == isa::Cpu::c40)) return;
  program_.warn(s.line, offset,
                is_c40 ? "a program for the C4x; it is encoded for the C3x, as --cpu c3x asks"
                       : "a program for the C3x; it is encoded for the C4x (--cpu c3x encodes for the C3x)");
}

/// `.dialect gnu`: for this file, and for the files that it includes unless they have their own.
void Reader::directive_dialect(Statement& s) {
  s.parser.skip_blanks();
  const std::size_t offset = s.parser.offset();
  const std::string text = s.parser.name_or_quoted("ti or gnu");
  s.parser.expect_end();
  const auto dialect = dialect_named(lower(text));
  if (!dialect) throw LineError{offset, fmt::format("there is no dialect '{}'; ti and gnu are possible", text)};
  if (reading_.said) throw LineError{s.operation_offset, "the file has a '.dialect' already"};
  if (reading_.has_code)
    throw LineError{s.operation_offset, "'.dialect' must come before the file's first instruction"};
  reading_ = {*dialect, fmt::format(".dialect in line {}", s.line->number), true, false};
  if (*dialect == Dialect::gnu) program_.leave_undefined_to_others();
}

void Reader::directive_warning(Statement& s) {
  program_.warn(s.line, s.operation_offset,
                s.parser.at_end() ? "warning requested by the source" : s.parser.name_or_quoted("a message"));
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
  if (const auto named = s.parser.lone_register()) {
    s.parser.expect_end();
    const auto [at, fresh] = registers_.insert({name, *named});
    if (program_.is_defined(name) || (!fresh && at->second != *named))
      throw LineError{s.label_offset, fmt::format("'{}' is defined already", name)};
    return;
  }
  if (registers_.contains(name))
    throw LineError{s.label_offset, fmt::format("'{}' is defined already: as a register", name)};
  Expression expression = s.parser.expression();
  s.parser.expect_end();
  program_.define(name, std::move(expression), s.line, s.label_offset);
}

void Reader::directive_include(Statement& s) {
  s.parser.skip_blanks();
  const std::size_t offset = s.parser.offset();
  const std::filesystem::path name = s.parser.name_or_quoted("the file's name");
  s.parser.expect_end();
  std::vector<std::filesystem::path> places{directory_ / name};
  for (const auto& directory : options_.include_dirs) places.push_back(directory / name);
  std::string tried;
  for (const auto& place : places) {
    const auto found = in_any_case(place);
    if (!found) {
      tried += (tried.empty() ? "" : ", ") + place.string();
      continue;
    }
    try {
      return read_file(*found);
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
                  s.parser.at_end() ? "error requested by the source" : s.parser.name_or_quoted("a message")};
}

void Reader::directive_nothing(Statement&) {}

void Reader::directive_stray(Statement& s) {
  throw LineError{s.operation_offset, fmt::format("'{}' closes nothing", s.operation)};
}

}  // namespace toolchain
