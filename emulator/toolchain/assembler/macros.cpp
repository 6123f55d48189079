// Macros and repeats of the assembler's reader.
#include <fmt/format.h>

#include <utility>

#include "isa/ascii.hpp"
#include "toolchain/assembler/reader.hpp"

namespace toolchain {
namespace {

constexpr int deepest_expansion = 100;
constexpr std::int64_t most_repeats = 1'000'000;
constexpr std::int64_t usual_repeats = 1024;  // The default of TI's tools.

/// Quotes keep an argument with commas together and are not part of it; """text""" gives "text".
std::string without_quotes(const std::string& argument) {
  if (argument.size() < 2 || argument.front() != '"' || argument.back() != '"') return argument;
  const std::string inside = argument.substr(1, argument.size() - 2);
  std::string out;
  for (std::size_t i = 0; i < inside.size(); ++i) {
    out += inside[i];
    if (inside[i] == '"' && i + 1 < inside.size() && inside[i + 1] == '"') ++i;
  }
  return out;
}

}  // namespace

/// Splits at commas outside parentheses, quotes and character constants. Names that end in '?' belong to the caller's
/// scope.
std::vector<std::string> Reader::macro_arguments(std::string_view text) const {
  std::vector<std::string> out(1);
  int depth = 0;
  bool in_quotes = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (const std::size_t length = in_quotes ? 0 : character_constant(text.substr(i)); length != 0) {
      out.back() += text.substr(i, length);
      i += length - 1;
      continue;
    }
    const char c = text[i];
    if (c == '"') in_quotes = !in_quotes;
    if (!in_quotes && c == '(') ++depth;
    if (!in_quotes && c == ')') --depth;
    if (!in_quotes && depth == 0 && c == ',') {
      out.emplace_back();
      continue;
    }
    out.back() += c;
    const bool scoped = i + 1 < text.size() && is_digit(text[i + 1]);
    if (!in_quotes && c == '?' && !scoped) out.back() += std::to_string(local_scope_);
  }
  for (std::string& argument : out) argument = without_quotes(std::string(ascii::trimmed(argument)));
  if (out.size() == 1 && out[0].empty()) out.clear();
  return out;
}

void Reader::expand(const Macro& macro, Statement& s) {
  if (expansion_depth_ >= deepest_expansion) {
    report(*s.line, {s.operation_offset, fmt::format("macro calls are nested deeper than {}", deepest_expansion)});
    given_up_ = true;
    return;
  }
  auto given = macro_arguments(s.parser.rest());
  // Superfluous arguments belong to the last parameter, as a list.
  while (given.size() > macro.parameters.size() && !macro.parameters.empty()) {
    const std::string last = std::move(given.back());
    given.pop_back();
    given.back() += "," + last;
  }
  if (given.size() > macro.parameters.size())
    throw LineError{s.operation_offset,
                    fmt::format("the macro '{}' takes {} argument{}, not {}", s.operation, macro.parameters.size(),
                                macro.parameters.size() == 1 ? "" : "s", given.size())};
  Substitutes arguments;
  for (std::size_t i = 0; i < macro.parameters.size(); ++i) {
    const Parameter& parameter = macro.parameters[i];
    arguments[parameter.name] = i < given.size() && !given[i].empty() ? given[i] : parameter.fallback;
  }
  Substitutes* const outer_parameters = std::exchange(parameters_, &arguments);
  const int outer_scope = std::exchange(local_scope_, ++last_scope_);
  const int outer_repeats = std::exchange(repeat_depth_, 0);
  read_lines(macro.body, s.line);
  if (leaving_ == Leaving::macro) leaving_ = Leaving::nothing;
  repeat_depth_ = outer_repeats;
  local_scope_ = outer_scope;
  parameters_ = outer_parameters;
}

void Reader::read_lines(const std::vector<SourceLinePtr>& body, const SourceLinePtr& from) {
  const std::size_t outer_conditionals = conditionals_.size();
  ++expansion_depth_;
  for (const SourceLinePtr& line : body) {
    if (stopped()) break;
    read_line(std::make_shared<const SourceLine>(SourceLine{line->file, line->number, line->text, from}));
  }
  --expansion_depth_;
  if (leaving_ != Leaving::nothing) conditionals_.resize(outer_conditionals);
  end_of_source(outer_conditionals);
}

void Reader::leave_macro(Statement& s) {
  s.parser.expect_end();
  if (parameters_ == nullptr) throw LineError{s.operation_offset, "'.mexit' outside a macro"};
  leaving_ = Leaving::macro;
}

/// `.break [condition]`
void Reader::leave_repeat(Statement& s) {
  const bool leave = s.parser.at_end() || known_number(s.parser, "the condition") != 0;
  s.parser.expect_end();
  if (repeat_depth_ == 0) throw LineError{s.operation_offset, "'.break' outside a .loop"};
  if (leave) leaving_ = Leaving::repeat;
}

/// `.asg text,symbol`; a text with commas is in quotes.
void Reader::assign_text(Statement& s) {
  Parser& p = s.parser;
  p.skip_blanks();
  std::string text;
  if (p.peek() == '"') {
    text = p.quoted();
  } else {
    const auto rest = p.rest();
    const auto comma = rest.find(',');
    if (comma == std::string_view::npos) throw LineError{p.offset(), ".asg takes a text and a symbol: .asg AR3,FP"};
    text = rest.substr(0, comma);
    text.erase(text.find_last_not_of(" \t") + 1);
    p.seek(p.offset() + comma);
  }
  p.expect(",");
  const std::string name = p.required_identifier("a symbol");
  p.expect_end();
  SubstituteScopes{parameters_, &substitutes_}.owner(name)[name] = std::move(text);
}

/// `.eval expression,symbol`
void Reader::assign_number(Statement& s) {
  const std::int64_t value = known_number(s.parser, "the value");
  s.parser.expect(",");
  const std::string name = s.parser.required_identifier("a symbol");
  s.parser.expect_end();
  SubstituteScopes{parameters_, &substitutes_}.owner(name)[name] = std::to_string(value);
}

/// `.var symbol,...`: substitution symbols of this expansion only.
void Reader::declare_variables(Statement& s) {
  if (parameters_ == nullptr) throw LineError{s.operation_offset, "'.var' outside a macro"};
  do (*parameters_)[s.parser.required_identifier("a symbol")] = "";
  while (s.parser.accept(","));
  s.parser.expect_end();
}

void Reader::forget_text(Statement& s) {
  do substitutes_.erase(s.parser.required_identifier("a symbol"));
  while (s.parser.accept(","));
  s.parser.expect_end();
}

void Reader::start_macro(Statement& s) {
  auto collector = std::make_unique<Collector>();
  collector->opening = s.line;
  collector->directive = lower(s.operation);
  collector_ = std::move(collector);  // First of all, so that after an error in the head the body is still collected.
  Parser& p = s.parser;
  std::string name = s.label;
  if (name.empty()) {
    name = p.required_identifier("the macro's name");
    p.accept(",");
  }
  if (!p.at_end()) {
    do {
      Parameter parameter{p.required_identifier("a parameter"), {}};
      if (p.accept("=")) {
        const auto tail = p.rest();
        const auto comma = tail.find(',');
        parameter.fallback = std::string(tail.substr(0, comma));
        while (!parameter.fallback.empty() && ascii::is_space(parameter.fallback.back())) parameter.fallback.pop_back();
        p.seek(p.offset() + (comma == std::string_view::npos ? tail.size() : comma));
      }
      collector_->macro.parameters.push_back(std::move(parameter));
    } while (p.accept(","));
  }
  p.expect_end();
  if (macros_.contains(name))
    program_.warn(s.line, s.operation_offset,
                  fmt::format("the macro '{}' is defined already; the new definition is used from here on", name));
  collector_->name = std::move(name);
  collector_->kind = Collector::Kind::macro;
}

void Reader::start_repeat(Statement& s) {
  collector_ = std::make_unique<Collector>();
  collector_->opening = s.line;
  collector_->directive = lower(s.operation);
  const std::int64_t count = s.parser.at_end() ? usual_repeats : known_number(s.parser, "the number of repeats");
  s.parser.expect_end();
  if (count < 0 || count > most_repeats)
    throw LineError{s.operation_offset, fmt::format("0 to {} repeats are possible", most_repeats)};
  if (expansion_depth_ >= deepest_expansion) throw LineError{s.operation_offset, "repeats are nested too deep"};
  collector_->count = count;
  collector_->kind = Collector::Kind::repeat;
}

}  // namespace toolchain
