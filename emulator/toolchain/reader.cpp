#include "toolchain/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <sstream>
#include <utility>

#include "toolchain/encoder.hpp"

namespace toolchain {
namespace {

constexpr std::size_t deepest_include = 64;
constexpr std::size_t most_errors = 1000;
constexpr std::int64_t most_lines = 1'000'000;  // Reached by macros that call themselves, not by programs.

/// The first word of a line that is a directive, without its label.
bool opens_collection(std::string_view operation) {
  return operation == ".macro" || operation == ".rept" || operation == ".loop";
}
bool closes_collection(std::string_view operation) {
  return operation == ".endm" || operation == ".endr" || operation == ".endloop";
}

}  // namespace

Reader::Reader(Program& program, const Options& options, std::vector<Diagnostic>& diagnostics)
    : program_(program), options_(options), diagnostics_(diagnostics) {}

ParseContext Reader::context() const { return {program_.here(), fmt::format("?{}", local_scope_)}; }

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
  if (std::filesystem::is_directory(path, error)) throw LineError{0, fmt::format("'{}' is a directory", path.string())};
  std::ifstream stream(path, std::ios::binary);
  std::stringstream text;
  text << stream.rdbuf();
  if (!stream) throw LineError{0, fmt::format("cannot read '{}'", path.string())};
  open_files_.push_back(canonical);
  read_text(text.str(), path.string(), path.parent_path());
  open_files_.pop_back();
}

void Reader::read_text(std::string_view text, const std::string& name, const std::filesystem::path& directory) {
  const auto file = std::make_shared<const std::string>(name);
  const auto outer_directory = std::exchange(directory_, directory);
  const int outer_scope = std::exchange(local_scope_, ++last_scope_);
  const std::size_t outer_conditionals = conditionals_.size();
  int number = 0;
  while (!text.empty() && !stopped()) {
    const auto end = text.find('\n');
    auto line = text.substr(0, end);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    read_line(std::make_shared<const SourceLine>(SourceLine{file, ++number, std::string(line), nullptr}));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  end_of_source(outer_conditionals);
  ended_ = false;
  local_scope_ = outer_scope;
  directory_ = outer_directory;
}

void Reader::end_of_source(std::size_t outer_conditionals) {
  if (collector_) {
    const bool macro = collector_->kind != Collector::Kind::repeat;
    report(*collector_->opening, {0, macro ? ".macro has no .endm" : ".rept has no .endr"});
    collector_.reset();
  }
  while (conditionals_.size() > outer_conditionals) {
    report(*conditionals_.back().opening, {0, ".if has no .endif"});
    conditionals_.pop_back();
  }
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
    else if (is_mnemonic(lower(word)) || macros_.contains(word))
      throw LineError{
          start,
          fmt::format("'{}' stands in the first column, where labels stand; indent it, or write '{}:' for a label",
                      word, word)};
    out.label = std::move(word);
    out.label_offset = start;
    p.skip_blanks();
    start = p.offset();
    if (p.at_bars()) throw LineError{start, "a label cannot stand between the halves of a parallel instruction"};
    word = p.identifier();
    if (word.empty() && !p.at_end()) throw LineError{start, "an instruction or a directive expected"};
  }
  out.operation = std::move(word);
  out.operation_offset = start;
  return out;
}

bool Reader::collect(const SourceLinePtr& line) {
  if (!collector_) return false;
  std::string operation;
  try {
    operation = lower(take_apart(line).operation);
  } catch (const LineError&) {
    // Whatever is wrong with the line shows when it is expanded.
  }
  if (opens_collection(operation)) ++collector_->depth;
  if (closes_collection(operation) && --collector_->depth == 0)
    finish_collecting();
  else
    collector_->macro.body.push_back(line);
  return true;
}

void Reader::finish_collecting() {
  const auto collected = std::move(collector_);
  if (collected->kind == Collector::Kind::macro) {
    macros_[collected->name] = std::move(collected->macro);
    return;
  }
  if (collected->kind == Collector::Kind::broken || collected->macro.body.empty()) return;
  for (std::int64_t i = 0; i < collected->count && !stopped(); ++i)
    read_lines(collected->macro.body, collected->opening, {});
}

void Reader::open_conditional(bool condition, const SourceLinePtr& line) {
  const bool parent = is_active();
  conditionals_.push_back({parent && condition, condition, parent, false, line});
}

bool Reader::conditional(Statement& s) {
  const std::string operation = lower(s.operation);
  Parser& p = s.parser;
  if (operation == ".if" || operation == ".ifdef" || operation == ".ifndef") {
    bool condition = false;
    try {
      if (is_active()) {
        if (operation == ".if")
          condition = known_number(p, "the condition") != 0;
        else
          condition = program_.is_defined(p.required_identifier("a symbol")) == (operation == ".ifdef");
        p.expect_end();
      }
    } catch (const LineError& error) {
      report(*s.line, error);
    }
    open_conditional(condition, s.line);
    return true;
  }
  if (operation != ".else" && operation != ".elseif" && operation != ".endif") return false;
  if (conditionals_.empty()) throw LineError{s.operation_offset, fmt::format("'{}' without .if", operation)};
  Conditional& c = conditionals_.back();
  if (operation == ".endif") {
    conditionals_.pop_back();
    return true;
  }
  if (c.after_else) throw LineError{s.operation_offset, fmt::format("'{}' after .else", operation)};
  c.after_else = operation == ".else";
  const bool possible = c.parent && !c.taken;
  c.active = possible && (c.after_else || known_number(p, "the condition") != 0);
  c.taken = c.taken || c.active;
  return true;
}

void Reader::read_line(const SourceLinePtr& line) {
  if (given_up_) return;
  if (++lines_read_ > most_lines) {
    report(*line, {0, fmt::format("more than {} lines to assemble; does a macro call itself?", most_lines)});
    given_up_ = true;
    return;
  }
  if (collect(line)) return;
  try {
    Statement statement = take_apart(line);
    if (!statement.operation.empty() && conditional(statement)) return;
    if (is_active()) read_active_line(statement);
  } catch (const LineError& error) {
    if (is_active()) report(*line, error);
  }
}

void Reader::define_label(const Statement& s) { program_.define(s.label, program_.here(), s.line, s.label_offset); }

void Reader::read_active_line(Statement& s) {
  if (s.bars) {
    HalfSyntax half = s.parser.half();
    s.parser.expect_end();
    return program_.add_parallel(std::move(half), s.line, 0);
  }
  const std::string operation = lower(s.operation);
  if (!operation.empty() && operation[0] == '.') {
    const auto found = directives().find(operation);
    if (found == directives().end())
      throw LineError{s.operation_offset, fmt::format("no directive is called '{}'", s.operation)};
    program_.end_instruction();
    return (this->*found->second)(s);
  }
  if (!s.label.empty()) {
    program_.end_instruction();
    define_label(s);
  }
  if (operation.empty()) return;
  if (const auto macro = macros_.find(s.operation); macro != macros_.end()) {
    program_.end_instruction();
    const Macro copy = macro->second;  // It may redefine itself.
    return expand(copy, s);
  }
  instruction(s);
}

void Reader::instruction(Statement& s) {
  Parser& p = s.parser;
  p.seek(s.operation_offset);
  InstructionItem item{.first = p.half(), .second = {}, .second_line = nullptr};
  if (p.accept("||")) {
    item.second = p.half();
    item.second_line = s.line;
  }
  p.expect_end();
  program_.add(s.line, s.operation_offset, std::move(item));
}

}  // namespace toolchain
