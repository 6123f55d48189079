#include "toolchain/syntax/parser.hpp"

#include <fmt/format.h>

#include <array>

#include "isa/ascii.hpp"
#include "toolchain/syntax/diagnostics.hpp"

namespace toolchain {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// Binary operators from the weakest to the strongest, as in C.
constexpr std::array<std::array<std::string_view, 4>, 8> operator_levels{{
    {"&&"},
    {"|"},
    {"^"},
    {"&"},
    {"==", "!=", "="},
    {"<=", ">=", "<", ">"},
    {"<<", ">>"},
    {"+", "-"},
}};

}  // namespace

std::string_view without_comment(std::string_view line, Dialect dialect) {
  if (!line.empty() && line[0] == '*') return {};
  const std::size_t first = line.find_first_not_of(" \t");
  if (dialect == Dialect::gnu && first != std::string_view::npos && line[first] == '#') return {};
  char quote = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quote != 0) {
      if (c == '\\' && quote == '"')
        ++i;
      else if (c == quote)
        quote = 0;
    } else if (c == '"') {
      quote = c;
    } else if (const std::size_t length = character_constant(line.substr(i)); length != 0) {
      i += length - 1;
    } else if (c == ';') {
      return line.substr(0, i);
    }
  }
  return line;
}

bool is_identifier_start(char c) { return ascii::is_letter(c) || c == '_' || c == '.' || c == '$'; }
bool is_identifier(char c) { return is_identifier_start(c) || is_digit(c); }

Parser::Parser(std::string_view line, ParseContext context)
    : text_(without_comment(line, context.dialect)), context_(std::move(context)) {}

void Parser::skip_blanks() {
  while (is_blank(peek())) ++position_;
}

bool Parser::at_end() {
  skip_blanks();
  return position_ >= text_.size();
}

bool Parser::accept(std::string_view token) {
  skip_blanks();
  if (!starts_with(token)) return false;
  position_ += token.size();
  return true;
}

void Parser::expect(std::string_view token) {
  if (!accept(token)) throw LineError{position_, fmt::format("'{}' expected", token)};
}

void Parser::expect_end() {
  if (!at_end()) throw LineError{position_, fmt::format("end of line expected, not '{}'", rest())};
}

std::string Parser::identifier() {
  skip_blanks();
  if (!is_identifier_start(peek())) return {};
  const std::size_t start = position_;
  while (is_identifier(peek())) ++position_;
  std::string name(text_.substr(start, position_ - start));
  if (name.size() == 2 && name[0] == '$' && is_digit(name[1])) name += context_.block_suffix;
  if (peek() == '?') {
    const std::size_t mark = position_++;
    while (is_digit(peek())) ++position_;  // A macro argument contains the scope of its caller.
    name += position_ > mark + 1 ? std::string(text_.substr(mark, position_ - mark)) : context_.local_suffix;
  }
  return name;
}

std::string Parser::required_identifier(std::string_view what) {
  skip_blanks();
  const std::size_t start = position_;
  std::string name = identifier();
  if (name.empty()) throw LineError{start, fmt::format("{} expected", what)};
  return name;
}

std::string Parser::quoted() {
  skip_blanks();
  const std::size_t start = position_;
  expect("\"");
  std::string out;
  for (;; ++position_) {
    if (position_ >= text_.size()) throw LineError{start, "this string has no closing quote"};
    char c = text_[position_];
    if (c == '"') {
      if (peek(1) != '"') break;
      ++position_;
    } else if (c == '\\' && position_ + 1 < text_.size()) {
      c = text_[++position_];
      if (c == 'n')
        c = '\n';
      else if (c == 't')
        c = '\t';
      else if (c == 'r')
        c = '\r';
      else if (c == '0')
        c = '\0';
      else if (c != '\\' && c != '"')
        out += '\\';  // Not an escape: TI's strings have none, and a path may contain it.
    }
    out += c;
  }
  ++position_;
  return out;
}

std::string Parser::name_or_quoted(std::string_view what) {
  skip_blanks();
  if (peek() == '"') return quoted();
  const std::size_t start = position_;
  while (position_ < text_.size() && !is_blank(peek()) && peek() != ',') ++position_;
  if (position_ == start) throw LineError{start, fmt::format("{} expected", what)};
  return std::string(text_.substr(start, position_ - start));
}

std::string_view Parser::next_word() {
  skip_blanks();
  std::size_t end = position_;
  if (is_identifier_start(peek()))
    while (end < text_.size() && is_identifier(text_[end])) ++end;
  return text_.substr(position_, end - position_);
}

bool Parser::at_bars() {
  skip_blanks();
  return starts_with("||");
}

Expression Parser::expression() {
  operators_ = 0;
  return binary_expression(0);
}

/// Recursive functions walk through trees, so the depth has a limit.
void Parser::count_operator(std::size_t offset) {
  constexpr int most_operators = 500;
  if (++operators_ > most_operators)
    throw LineError{offset, fmt::format("an expression of more than {} operators and parentheses", most_operators)};
}

std::vector<Expression> Parser::expression_list() {
  std::vector<Expression> out;
  do out.push_back(expression());
  while (accept(","));
  return out;
}

/// The operator at this place, if it binds at least as strongly as `loosest`: its level and its text.
std::pair<int, std::string_view> Parser::operator_ahead(int loosest) {
  skip_blanks();
  const auto tightest = static_cast<int>(operator_levels.size());
  if (loosest <= tightest && (peek() == '*' || peek() == '/' || peek() == '%'))
    return {tightest, text_.substr(position_, 1)};
  if (starts_with("||")) return {};
  for (int level = tightest - 1; level >= loosest; --level) {
    const auto& operators = operator_levels[static_cast<std::size_t>(level)];
    if (operators[0] != "&&" && starts_with("&&")) continue;
    for (const auto op : operators) {
      const bool shift_ahead = (op == "<" && starts_with("<<")) || (op == ">" && starts_with(">>"));
      if (!op.empty() && starts_with(op) && !shift_ahead) return {level, op};
    }
  }
  return {};
}

/// Precedence climbing: a parenthesis costs two calls instead of one for every level.
Expression Parser::binary_expression(int loosest) {
  Expression left = unary_expression();
  for (;;) {
    const auto [level, op] = operator_ahead(loosest);
    if (op.empty()) return left;
    const std::size_t at = position_;
    position_ += op.size();
    count_operator(at);
    Expression right = binary_expression(level + 1);
    left = Expression{Expression::Kind::binary, {}, std::string(op), {std::move(left), std::move(right)}, at};
  }
}

Expression Parser::unary_expression() {
  skip_blanks();
  const std::size_t at = position_;
  const char c = peek();
  if (c == '+') {
    ++position_;
    count_operator(at);
    return unary_expression();
  }
  if (c == '-' || c == '~' || c == '!') {
    ++position_;
    count_operator(at);
    return Expression{Expression::Kind::unary, {}, std::string(1, c), {unary_expression()}, at};
  }
  return primary_expression();
}

Expression Parser::primary_expression() {
  skip_blanks();
  const std::size_t at = position_;
  if (accept("(")) {
    count_operator(at);
    Expression inner = binary_expression(0);
    expect(")");
    return inner;
  }
  if (peek() == '\'') return character();
  if (is_digit(peek()) || (peek() == '.' && is_digit(peek(1)))) return number();
  if ((peek() == '$' || peek() == '.') && !is_identifier(peek(1))) {
    ++position_;
    return Expression{Expression::Kind::constant, context_.here, {}, {}, at};
  }
  std::string name = identifier();
  if (name.empty()) {
    const std::string found = at < text_.size() ? fmt::format("'{}'", text_.substr(at)) : "the end of the line";
    throw LineError{at, fmt::format("a number, a symbol or '(' expected, not {}", found)};
  }
  if (peek() == '(') return call(lower(name), at);
  if (register_called(name) || expansion_called(name))
    throw LineError{
        at, fmt::format("the register {} cannot be part of an expression: a number or a symbol is needed", name)};
  return Expression{Expression::Kind::symbol, {}, std::move(name), {}, at};
}

Expression Parser::call(const std::string& function, std::size_t at) {
  constexpr std::array<std::string_view, 5> functions{"hi16", "lo16", "page", "single", "defined"};
  bool known = false;
  for (const auto name : functions) known = known || name == function;
  if (!known)
    throw LineError{
        at, fmt::format("there is no function '{}'; hi16, lo16, page, single and defined are possible", function)};
  expect("(");
  count_operator(at);
  Expression argument = binary_expression(0);
  expect(")");
  if (function == "defined") {  // Before this line, wherever the value is used.
    if (argument.kind != Expression::Kind::symbol)
      throw LineError{argument.offset, "defined() takes the name of a symbol"};
    const auto value = Value::of(std::int64_t{context_.symbols->is_defined(argument.name)});
    return Expression{Expression::Kind::constant, value, {}, {}, at};
  }
  return Expression{Expression::Kind::call, {}, function, {std::move(argument)}, at};
}

}  // namespace toolchain
