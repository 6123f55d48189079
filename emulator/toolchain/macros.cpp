// Macros and repeats of the assembler's reader.
#include <fmt/format.h>

#include <cctype>
#include <utility>

#include "toolchain/reader.hpp"

namespace toolchain {
namespace {

constexpr int deepest_expansion = 100;
constexpr std::int64_t most_repeats = 1'000'000;

bool is_name(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

using Arguments = std::map<std::string, std::string, std::less<>>;

/// Replaces parameters that stand alone outside quotes, and \name or :name: anywhere.
std::string substitute(const std::string& text, const Arguments& arguments) {
  if (arguments.empty()) return text;
  std::string out;
  bool in_quotes = false;
  const auto name_at = [&](std::size_t start, auto is_part) {
    std::size_t end = start;
    while (end < text.size() && is_part(text[end])) ++end;
    return std::string_view(text).substr(start, end - start);
  };
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '"') in_quotes = !in_quotes;
    if (c == '\\' || c == ':') {
      const auto name = name_at(i + 1, is_name);
      const auto found = arguments.find(name);
      const std::size_t after = i + 1 + name.size();
      if (found != arguments.end() && (c == '\\' || (after < text.size() && text[after] == ':'))) {
        out += found->second;
        i = after + (c == ':' ? 1 : 0);
        continue;
      }
    }
    if (is_identifier(c) && c != '.' && !in_quotes) {
      const auto name = name_at(i, is_identifier);
      const auto found = arguments.find(name);
      out += found != arguments.end() ? std::string_view(found->second) : name;
      i += name.size();
      continue;
    }
    out += c;
    ++i;
  }
  return out;
}

}  // namespace

/// Splits at commas outside parentheses and quotes. Names ending in '?' belong to the caller's scope.
std::vector<std::string> Reader::macro_arguments(std::string_view text) const {
  std::vector<std::string> out(1);
  int depth = 0;
  bool in_quotes = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') in_quotes = !in_quotes;
    if (!in_quotes && c == '(') ++depth;
    if (!in_quotes && c == ')') --depth;
    if (!in_quotes && depth == 0 && c == ',') {
      out.emplace_back();
      continue;
    }
    out.back() += c;
    const bool scoped = i + 1 < text.size() && std::isdigit(static_cast<unsigned char>(text[i + 1])) != 0;
    if (!in_quotes && c == '?' && !scoped) out.back() += std::to_string(local_scope_);
  }
  for (std::string& argument : out) {
    const auto first = argument.find_first_not_of(" \t\r");
    const auto last = argument.find_last_not_of(" \t\r");
    argument = first == std::string::npos ? std::string() : argument.substr(first, last - first + 1);
  }
  if (out.size() == 1 && out[0].empty()) out.clear();
  return out;
}

void Reader::expand(const Macro& macro, Statement& s) {
  if (expansion_depth_ >= deepest_expansion) {
    report(*s.line, {s.operation_offset, fmt::format("macro calls are nested deeper than {}", deepest_expansion)});
    given_up_ = true;
    return;
  }
  const auto given = macro_arguments(s.parser.rest());
  if (given.size() > macro.parameters.size())
    throw LineError{s.operation_offset,
                    fmt::format("the macro '{}' takes {} argument{}, not {}", s.operation, macro.parameters.size(),
                                macro.parameters.size() == 1 ? "" : "s", given.size())};
  Arguments arguments;
  for (std::size_t i = 0; i < macro.parameters.size(); ++i) {
    const Parameter& parameter = macro.parameters[i];
    arguments[parameter.name] = i < given.size() && !given[i].empty() ? given[i] : parameter.fallback;
  }
  read_lines(macro.body, s.line, arguments);
}

void Reader::read_lines(const std::vector<SourceLinePtr>& body, const SourceLinePtr& from, const Arguments& arguments) {
  const int outer_scope = std::exchange(local_scope_, ++last_scope_);
  const std::size_t outer_conditionals = conditionals_.size();
  ++expansion_depth_;
  for (const SourceLinePtr& line : body) {
    if (stopped()) break;
    read_line(std::make_shared<const SourceLine>(
        SourceLine{line->file, line->number, substitute(line->text, arguments), from}));
  }
  --expansion_depth_;
  end_of_source(outer_conditionals);
  local_scope_ = outer_scope;
}

void Reader::start_macro(Statement& s) {
  auto collector = std::make_unique<Collector>();
  collector->opening = s.line;
  collector_ = std::move(collector);  // First of all, so that a faulty head does not let its body loose.
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
        while (!parameter.fallback.empty() && std::isspace(static_cast<unsigned char>(parameter.fallback.back())) != 0)
          parameter.fallback.pop_back();
        p.seek(p.offset() + (comma == std::string_view::npos ? tail.size() : comma));
      }
      collector_->macro.parameters.push_back(std::move(parameter));
    } while (p.accept(","));
  }
  p.expect_end();
  if (macros_.contains(name))
    throw LineError{s.operation_offset, fmt::format("the macro '{}' is defined already", name)};
  collector_->name = std::move(name);
  collector_->kind = Collector::Kind::macro;
}

void Reader::start_repeat(Statement& s) {
  if (!s.label.empty()) define_label(s);
  collector_ = std::make_unique<Collector>();
  collector_->opening = s.line;
  const std::int64_t count = known_number(s.parser, "the number of repeats");
  s.parser.expect_end();
  if (count < 0 || count > most_repeats)
    throw LineError{s.operation_offset, fmt::format("0 to {} repeats", most_repeats)};
  if (expansion_depth_ >= deepest_expansion) throw LineError{s.operation_offset, "repeats are nested too deep"};
  collector_->count = count;
  collector_->kind = Collector::Kind::repeat;
}

}  // namespace toolchain
