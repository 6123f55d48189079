#include "toolchain/assembler/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "io/input_file.hpp"
#include "io/stop.hpp"
#include "io/text_form.hpp"
#include "toolchain/encoder/encoder.hpp"

namespace toolchain {
namespace {

constexpr std::size_t deepest_include = 64;
constexpr std::int64_t lines_between_looks = 4096;  // whether the assembly is to be stopped
constexpr std::size_t longest_line = 1 << 16;
constexpr std::int64_t most_lines = 1'000'000;  // Only macros that call themselves have more.

SourceLinePtr with_text(const SourceLinePtr& line, std::string text) {
  return std::make_shared<const SourceLine>(SourceLine{line->file, line->number, std::move(text), line->expanded_from});
}

/// `NAME EQU 5`, as in assemblers without TI's dots.
bool is_undotted_set(std::string_view operation) { return operation == "equ"; }

/// Why the whole text cannot be read line by line; empty where it can.
std::string form_problem(std::string_view text) {
  const std::size_t end = text.find('\r');
  if (text.find('\n') == std::string_view::npos && end != std::string_view::npos &&
      text.find_first_not_of('\r', end) != std::string_view::npos)
    return "the lines end in a carriage return alone; a line feed is expected at each end, or both";
  return io::wide_form_problem(text);
}

}  // namespace

Reader::Reader(Program& program, const Options& options, std::vector<Diagnostic>& diagnostics)
    : program_(program), options_(options), diagnostics_(diagnostics) {
  if (options.undefined_external || options.dialect == Dialect::gnu) program.leave_undefined_to_others();
  if (options.dialect)
    reading_ = {*options.dialect, "asked for"};
  else
    reading_.why = "the default";
}

ParseContext Reader::context() const {
  return {&program_,
          program_.here(),
          fmt::format("?{}", local_scope_),
          fmt::format("?{}", block_),
          &registers_,
          reading_.dialect,
          &parser_warnings_,
          options_.cpu};
}

/// Ends the scope of $0 to $9 and, outside macros, of names ending in '?'.
void Reader::new_block() {
  block_ = ++last_scope_;
  if (parameters_ == nullptr) local_scope_ = block_;
}

void Reader::report(const SourceLine& line, const LineError& error) {
  if (given_up_) return;
  given_up_ = diagnostics_.size() >= most_errors;
  diagnostics_.push_back(make_diagnostic(line, error.offset, error.message));
}

void Reader::read_file(const std::filesystem::path& path) {
  std::error_code error;
  const auto canonical = std::filesystem::weakly_canonical(path, error);
  if (std::find(open_files_.begin(), open_files_.end(), canonical) != open_files_.end())
    throw LineError{0, fmt::format("the file '{}' includes itself", path.string())};
  if (open_files_.size() >= deepest_include)
    throw LineError{0, fmt::format("includes are nested deeper than {}", deepest_include)};
  const io::Input input = io::read_input(path);
  if (!input.problem.empty()) throw LineError{0, fmt::format("'{}' {}", path.string(), input.problem)};
  open_files_.push_back(canonical);
  program_.note_file_read(path.string());
  read_text(input.text, path.string(), path.parent_path());
  open_files_.pop_back();
}

void Reader::read_text(std::string_view text, const std::string& name, const std::filesystem::path& directory) {
  const auto file = std::make_shared<const std::string>(name);
  const auto outer_directory = std::exchange(directory_, directory);
  const int outer_scope = local_scope_;
  Substitutes* const outer_parameters = std::exchange(parameters_, nullptr);
  const Reading outer_reading = reading_;
  reading_.said = reading_.has_code = false;
  const bool is_included = open_texts_++ > 0;
  const std::size_t outer_conditionals = conditionals_.size();
  new_block();
  int number = 0;
  text = io::without_mark(text.substr(0, text.find('\x1A')));  // the end of a file in DOS
  if (const std::string problem = form_problem(text); !problem.empty()) {
    report(SourceLine{file, 1, "", nullptr}, {0, problem});
    text = {};
  }
  while (!text.empty() && !stopped()) {
    const auto end = text.find('\n');
    auto line = text.substr(0, end);
    while (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.starts_with('\f')) line.remove_prefix(1);  // a new page of the listing, as old editors mark it
    ++number;
    if (line.size() > longest_line)
      report(SourceLine{file, number, std::string(line.substr(0, 80)), nullptr},
             {0, fmt::format("a line of {} characters; {} are the most", line.size(), longest_line)});
    else if (const std::size_t zero = line.find('\0'); zero != std::string_view::npos)
      report(SourceLine{file, number, std::string(line.substr(0, zero)), nullptr},
             {zero, "a byte 0 is here; a text is expected"});
    else
      read_line(std::make_shared<const SourceLine>(SourceLine{file, number, std::string(line), nullptr}));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  end_of_source(outer_conditionals);
  --open_texts_;
  if (!is_included)
    program_.note_dialect(fmt::format("{}: {}", toolchain::name(reading_.dialect), reading_.why), true);
  else if (reading_.why != outer_reading.why)
    program_.note_dialect(fmt::format("{} in {}: {}", toolchain::name(reading_.dialect), name, reading_.why));
  reading_ = outer_reading;
  ended_ = false;
  new_block();
  parameters_ = outer_parameters;
  local_scope_ = outer_scope;
  directory_ = outer_directory;
}

void Reader::end_of_source(std::size_t outer_conditionals) {
  if (collector_) {
    report_open(collector_->opening);
    collector_.reset();
  }
  if (structure_ && open_files_.size() <= 1 && expansion_depth_ == 0) {
    report_open(structure_->opening);
    structure_.reset();
  }
  while (conditionals_.size() > outer_conditionals) {
    report_open(conditionals_.back().opening);
    conditionals_.pop_back();
  }
}

/// What the line opens was not closed.
void Reader::report_open(const SourceLinePtr& opening) {
  const std::string name = lower(take_apart(opening).operation);
  report(*opening, {0, fmt::format("{} has no {}", name, directive_named(name)->closing)});
}

Reader::Statement Reader::take_apart(const SourceLinePtr& line) const {
  Statement out{.line = line, .parser = Parser(line->text, context()), .label = {}, .operation = {}};
  Parser& p = out.parser;
  const bool in_first_column = !line->text.empty() && is_identifier_start(line->text[0]);
  if (p.at_end()) return out;
  if (p.accept("||")) {
    out.bars = true;
    return out;
  }
  std::size_t start = p.offset();
  std::string word = p.identifier();
  if (word.empty()) throw LineError{start, "a label, an instruction or a directive expected"};
  const bool colon = p.peek() == ':';
  if (colon || (in_first_column && word[0] != '.')) {
    if (colon)
      p.accept(":");
    else if (is_operation(word) && !macros_.contains(word) && !is_operation(p.next_word()))
      throw LineError{
          start, fmt::format("'{}' is in the first column, which is for labels; indent it, or write '{}:' for a label",
                             word, word)};
    out.label = std::move(word);
    out.label_offset = start;
    p.skip_blanks();
    start = p.offset();
    if (p.at_bars()) throw LineError{start, "a label is not possible between the halves of a parallel instruction"};
    word = p.identifier();
    if (word.empty() && !p.at_end()) throw LineError{start, "an instruction or a directive expected"};
  }
  out.operation = std::move(word);
  out.operation_offset = start;
  return out;
}

/// Whether the word names an instruction, a directive or a macro.
bool Reader::is_operation(std::string_view word) const {
  return !word.empty() && (word[0] == '.' || is_mnemonic(lower(word), options_.cpu) || macros_.contains(word) ||
                           is_undotted_set(lower(word)));
}

bool Reader::collect(const SourceLinePtr& line) {
  if (!collector_) return false;
  std::string operation, label;
  std::size_t at = 0;
  try {
    const Statement statement = take_apart(line);
    operation = lower(statement.operation), label = statement.label, at = statement.label_offset;
  } catch (const LineError&) {
    // An error in the line is reported when the line is expanded.
  }
  std::vector<Substitutes>& scopes = collector_->scopes;
  const Directive* const directive = directive_named(operation);
  const bool opens = directive != nullptr && directive->sort == Sort::collects;
  if (directive != nullptr && directive->sort == Sort::closes) scopes.pop_back();
  if (scopes.empty()) {
    if (!label.empty())
      report(*line, {at, fmt::format("'{}' takes no label; a line of its own before it is expected", operation)});
    finish_collecting();
    return true;
  }
  const bool repeat = collector_->kind == Collector::Kind::repeat;
  if (!repeat && line->text.starts_with('!')) return true;  // a comment of the definition
  if (opens) scopes.push_back(scopes.back());
  const Substitutes& outer = opens ? *std::prev(scopes.end(), 2) : scopes.back();
  if (repeat || outer.empty()) {
    collector_->macro.body.push_back(line);
    return true;
  }
  std::string text;
  for (const LinePart& part : parts_of(line)) {
    const std::string put = (part.declares ? substitute_forced : substitute)(part.text, outer, false);
    if (part.declares && (operation == ".macro" || operation == ".var"))
      scopes.back().erase(std::string(ascii::trimmed(put)));
    text += put;
  }
  collector_->macro.body.push_back(with_text(line, std::move(text)));
  return true;
}

void Reader::finish_collecting() {
  const auto collected = std::move(collector_);
  if (collected->kind == Collector::Kind::macro) {
    macros_[collected->name] = std::move(collected->macro);
    return;
  }
  if (collected->kind == Collector::Kind::broken || collected->macro.body.empty()) return;
  ++repeat_depth_;
  const int outer_scope = local_scope_;
  for (std::int64_t i = 0; i < collected->count && !stopped(); ++i) {
    local_scope_ = ++last_scope_;
    read_lines(collected->macro.body, collected->opening);
  }
  local_scope_ = outer_scope;
  --repeat_depth_;
  if (leaving_ == Leaving::repeat) leaving_ = Leaving::nothing;
}

/// Of `.if NUMBER`, `.elseif NUMBER`, `.ifdef SYMBOL` or `.ifndef SYMBOL`.
bool Reader::condition(Statement& s) {
  const std::string operation = lower(s.operation);
  if (operation != ".ifdef" && operation != ".ifndef") return known_number(s.parser, "the condition") != 0;
  return program_.is_defined(s.parser.required_identifier("a symbol")) == (operation == ".ifdef");
}

/// After an error the part is open, too: its .endif comes.
void Reader::open_conditional(Statement& s) {
  const bool parent = is_active();
  bool holds = false;
  try {
    if (parent) {
      place_label(s);
      holds = condition(s);
      s.parser.expect_end();
    }
  } catch (const LineError& error) {
    report(*s.line, error);
  }
  conditionals_.push_back({holds, holds, parent, false, s.line});
}

Reader::Conditional& Reader::open_one(const Statement& s) {
  if (conditionals_.empty()) throw LineError{s.operation_offset, fmt::format("'{}' without .if", lower(s.operation))};
  return conditionals_.back();
}

void Reader::close_conditional(Statement& s) {
  open_one(s);
  conditionals_.pop_back();
  if (is_active()) place_label(s);
}

/// .elseif or .else
void Reader::next_branch(Statement& s) {
  const std::string operation = lower(s.operation);
  Conditional& c = open_one(s);
  if (c.after_else) throw LineError{s.operation_offset, fmt::format("'{}' after .else", operation)};
  // The line stands at the end of one branch and at the beginning of the next.
  const bool ends_branch = c.active, possible = c.parent && !c.taken;
  c.after_else = operation == ".else";
  c.active = possible && c.after_else;
  try {
    if (possible && !c.after_else) {
      c.active = condition(s);
      s.parser.expect_end();
    }
    if (ends_branch || c.active) place_label(s);
  } catch (const LineError& error) {
    report(*s.line, error);
  }
  c.taken = c.taken || c.active;
}

/// The line in its parts. Most lines are one.
std::vector<Reader::LinePart> Reader::parts_of(const SourceLinePtr& line) const {
  const std::string& text = line->text;
  std::vector<LinePart> parts;
  std::size_t from = 0;
  const auto cut = [&](std::size_t at, bool declares) {
    if (at > from) parts.push_back({text.substr(from, at - from), declares});
    from = std::max(from, at);
  };
  try {
    Statement s = take_apart(line);
    const std::string operation = lower(s.operation);
    const std::size_t code = without_comment(text, reading_.dialect).size();
    if (operation == ".asg" || operation == ".eval") {
      if (const std::size_t comma = text.substr(0, code).rfind(','); comma != std::string::npos) {
        cut(comma + 1, false);
        cut(code, true);
      }
    } else if (operation == ".macro" || operation == ".var" || operation == ".unasg") {
      if (operation == ".macro") macro_name(s);
      cut(s.parser.offset(), false);
      while (from < code) {
        const std::size_t comma = std::min(text.find(',', from), code);
        cut(std::min(text.find('=', from), comma), true);
        cut(std::min(comma + 1, code), false);  // a parameter's default
      }
    }
  } catch (const LineError&) {
    // After substitution the line may be correct: ":NAME: nop".
  }
  cut(text.size(), false);
  return parts;
}

/// The line with its substitution symbols replaced, but not in the names that it declares.
SourceLinePtr Reader::substituted(const SourceLinePtr& line) {
  if (parameters_ == nullptr && substitutes_.empty() && line->text.find('$') == std::string::npos) return line;
  const SubstituteScopes scopes{parameters_, &substitutes_, options_.cpu,
                                [this](const std::string& name) { return program_.is_defined(name); }};
  std::string text;
  for (const auto& [part, declares] : parts_of(line)) {
    const auto replace = declares ? substitute_forced : substitute;
    std::string put = declares ? part : replace_functions(part, without_comment(part, reading_.dialect).size(), scopes);
    if (parameters_ != nullptr) put = replace(put, *parameters_, false);
    text += replace(put, substitutes_, true);
  }
  return text == line->text ? line : with_text(line, std::move(text));
}

void Reader::read_line(const SourceLinePtr& raw_line) {
  if (given_up_) return;
  if (++lines_read_ > most_lines) {
    report(*raw_line, {0, fmt::format("more than {} lines to assemble; does a macro call itself?", most_lines)});
    given_up_ = true;
    return;
  }
  if (lines_read_ % lines_between_looks == 0) io::stop_if_asked();
  if (collect(raw_line)) return;
  SourceLinePtr line = raw_line;
  try {
    line = substituted(raw_line);
    parser_warnings_.clear();
    Statement statement = take_apart(line);
    const Directive* const directive = directive_named(lower(statement.operation));
    if (directive != nullptr && directive->sort == Sort::conditional) return (this->*directive->read)(statement);
    if (is_active()) read_active_line(statement);
    for (const LineError& warning : std::exchange(parser_warnings_, {}))
      program_.warn(line, warning.offset, warning.message);
  } catch (const LineError& error) {
    if (is_active()) report(*line, error);
  }
}

/// The label of a line without an operation, or whose operation has no use for it.
void Reader::place_label(const Statement& s) {
  if (s.label.empty()) return;
  program_.end_instruction();
  define_label(s);
}

void Reader::define_label(const Statement& s) {
  program_.end_field();  // The label names what comes after it, not the rest of a word.
  program_.define(s.label, program_.here(), s.line, s.label_offset);
  if (s.label == "gcc2_compiled.") gcc_mark(s);
}

/// GCC writes a mark at the top of a file: the file is in GNU's dialect, unless the source or an option names one.
void Reader::gcc_mark(const Statement& s) {
  if (options_.dialect || reading_.said || reading_.dialect == Dialect::gnu) return;
  if (reading_.has_code)
    return program_.warn(s.line, s.label_offset,
                         "GCC's mark comes after instructions, which were read in the dialect ti; .dialect gnu at "
                         "the top, or --dialect gnu, is for the whole");
  reading_.dialect = Dialect::gnu;
  program_.leave_undefined_to_others();
  reading_.why = fmt::format("GCC's mark gcc2_compiled. in line {}", s.line->number);
}

void Reader::read_active_line(Statement& s) {
  if (s.bars) {
    HalfSyntax half = s.parser.half();
    s.parser.expect_end();
    return program_.add_parallel(std::move(half), s.line, 0);
  }
  const std::string operation = lower(s.operation);
  if (structure_ && (operation.empty() || operation[0] == '.')) return member(s);
  if (!operation.empty() && operation[0] == '.') {
    const Directive* const directive = directive_named(operation);
    if (directive == nullptr)
      throw LineError{s.operation_offset,
                      fmt::format("there is no directive '{}'{}", s.operation, directive_near(operation))};
    program_.end_instruction();
    if (directive->label_is_here) place_label(s);
    return (this->*directive->read)(s);
  }
  if (is_undotted_set(operation) && !s.label.empty() && !macros_.contains(s.operation)) return directive_set(s);
  place_label(s);
  if (operation.empty()) return;
  if (const auto macro = macros_.find(s.operation); macro != macros_.end()) {
    program_.end_instruction();
    const Macro copy = macro->second;  // A copy: the macro may redefine itself.
    return expand(copy, s);
  }
  instruction(s);
}

void Reader::instruction(Statement& s) {
  Parser& p = s.parser;
  p.seek(s.operation_offset);
  reading_.has_code = true;
  InstructionItem item{.first = p.half(), .second = {}, .second_line = nullptr, .dialect = reading_.dialect};
  if (p.accept("||")) {
    item.second = p.half();
    item.second_line = s.line;
  }
  p.expect_end();
  program_.add(s.line, s.operation_offset, std::move(item));
}

}  // namespace toolchain
