#include "toolchain/parser.hpp"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <charconv>

#include "toolchain/diagnostics.hpp"

namespace toolchain {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// The line without its comment: from ';' outside quotes, or all of it if it starts with '*'.
std::string_view without_comment(std::string_view line) {
  if (!line.empty() && line[0] == '*') return {};
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
    } else if (c == '\'' && i + 2 < line.size() && line[i + 2] == '\'') {
      i += 2;
    } else if (c == ';') {
      return line.substr(0, i);
    }
  }
  return line;
}

std::optional<std::int64_t> integer_in_base(std::string_view digits, int base) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, base);
  if (digits.empty() || error != std::errc{} || end != digits.data() + digits.size() || value >> 63 != 0)
    return std::nullopt;
  return static_cast<std::int64_t>(value);
}

bool all_of(std::string_view text, std::string_view allowed) {
  return text.find_first_not_of(allowed) == std::string_view::npos;
}

constexpr std::string_view hex_digits = "0123456789abcdefABCDEF";

/// TI's and GNU's integer forms: 0FFh 101b 17q 0xFF 0b101 017 255.
std::optional<std::int64_t> integer_literal(std::string_view text) {
  const char first = text[0], last = static_cast<char>(std::tolower(static_cast<unsigned char>(text.back())));
  const auto body = text.substr(0, text.size() - 1);
  if (text.size() > 2 && first == '0' && (text[1] == 'x' || text[1] == 'X')) return integer_in_base(text.substr(2), 16);
  if (last == 'h' && all_of(body, hex_digits)) return integer_in_base(body, 16);
  if (last == 'b' && !body.empty() && all_of(body, "01")) return integer_in_base(body, 2);
  if (last == 'q' && all_of(body, "01234567")) return integer_in_base(body, 8);
  if (text.size() > 2 && first == '0' && (text[1] == 'b' || text[1] == 'B')) return integer_in_base(text.substr(2), 2);
  if (text.size() > 1 && first == '0') return integer_in_base(text.substr(1), 8);
  return integer_in_base(text, 10);
}

/// Binary operators from the loosest to the tightest, as in C.
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

bool is_identifier_start(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '$';
}
bool is_identifier(char c) { return is_identifier_start(c) || is_digit(c); }

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

Parser::Parser(std::string_view line, ParseContext context)
    : text_(without_comment(line)), context_(std::move(context)) {}

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
  if (!at_end()) throw LineError{position_, fmt::format("nothing more expected here, but there is '{}'", rest())};
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
    while (is_digit(peek())) ++position_;  // A macro argument brings the scope of its caller along.
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
        throw LineError{position_, fmt::format("unknown escape '\\{}'", c)};
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

/// Trees are walked by recursion, so their depth has a bound.
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

Expression Parser::binary_expression(int level) {
  const bool tightest = static_cast<std::size_t>(level) == operator_levels.size();
  const auto operand = [&] { return tightest ? unary_expression() : binary_expression(level + 1); };
  const auto next_operator = [&]() -> std::string_view {
    skip_blanks();
    if (tightest) {
      if (peek() == '*' || peek() == '/' || peek() == '%') return text_.substr(position_, 1);
      return {};
    }
    if (starts_with("||")) return {};
    const bool logical = operator_levels[static_cast<std::size_t>(level)][0] == "&&";
    if (!logical && starts_with("&&")) return {};
    for (const auto op : operator_levels[static_cast<std::size_t>(level)]) {
      const bool shift_ahead = (op == "<" && starts_with("<<")) || (op == ">" && starts_with(">>"));
      if (!op.empty() && starts_with(op) && !shift_ahead) return op;
    }
    return {};
  };
  Expression left = operand();
  for (auto op = next_operator(); !op.empty(); op = next_operator()) {
    const std::size_t at = position_;
    position_ += op.size();
    count_operator(at);
    Expression right = operand();
    left = Expression{Expression::Kind::binary, {}, std::string(op), {std::move(left), std::move(right)}, at};
  }
  return left;
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
  if (register_called(name) || isa::expansion_named(name))
    throw LineError{at, fmt::format("the register {} cannot be part of an expression", name)};
  return Expression{Expression::Kind::symbol, {}, std::move(name), {}, at};
}

Expression Parser::call(const std::string& function, std::size_t at) {
  constexpr std::array<std::string_view, 5> functions{"hi16", "lo16", "page", "single", "defined"};
  bool known = false;
  for (const auto name : functions) known = known || name == function;
  if (!known)
    throw LineError{at, fmt::format("no function '{}'; there are hi16, lo16, page, single and defined", function)};
  expect("(");
  count_operator(at);
  Expression argument = binary_expression(0);
  expect(")");
  if (function == "defined" && argument.kind != Expression::Kind::symbol)
    throw LineError{argument.offset, "defined() takes the name of a symbol"};
  return Expression{Expression::Kind::call, {}, function, {std::move(argument)}, at};
}

Expression Parser::character() {
  const std::size_t at = position_;
  if (accept("''''")) return Expression{Expression::Kind::constant, Value::of(std::int64_t{'\''}), {}, {}, at};
  if (position_ + 2 >= text_.size() || text_[position_ + 2] != '\'')
    throw LineError{at, "a character constant is one character between single quotes"};
  const auto code = static_cast<unsigned char>(text_[position_ + 1]);
  position_ += 3;
  return Expression{Expression::Kind::constant, Value::of(std::int64_t{code}), {}, {}, at};
}

/// GNU's 0f1.5, where it is no hexadecimal number.
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
  while (end < text_.size() && std::isalnum(static_cast<unsigned char>(text_[end]))) ++end;
  const auto word = text_.substr(at, end - at);
  if (const auto value = prefixed_float()) return Expression{Expression::Kind::constant, Value::of(*value), {}, {}, at};
  const bool point = end < text_.size() && text_[end] == '.';
  if (!point && !word.empty()) {
    if (const auto value = integer_literal(word)) {
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
    throw LineError{at, fmt::format("'{}' is no number (255, 0FFh, 0xFF, 377q, 101b, 1.5, 2.5e-3, 'A')",
                                    text_.substr(at, end - at))};
  }
  position_ = end;
  return Expression{Expression::Kind::constant, Value::of(*value), {}, {}, at};
}

std::optional<isa::Register> Parser::register_called(std::string_view name) const {
  if (const auto found = isa::register_named(name)) return found;
  if (context_.registers == nullptr) return std::nullopt;
  const auto alias = context_.registers->find(name);
  return alias == context_.registers->end() ? std::nullopt : std::optional(alias->second);
}

std::optional<isa::Register> Parser::lone_register() {
  const std::size_t start = position_;
  const auto found = accept_register();
  if (found && (at_end() || peek() == ',')) return found;
  position_ = start;
  return std::nullopt;
}

std::optional<isa::Register> Parser::accept_register() {
  skip_blanks();
  const std::size_t start = position_;
  if (!is_identifier_start(peek())) return std::nullopt;
  const auto found = register_called(identifier());
  if (!found) position_ = start;
  return found;
}

OperandSyntax Parser::operand() {
  skip_blanks();
  OperandSyntax out;
  out.offset = position_;
  if (peek() == '*') return indirect();
  if (accept("@")) {
    out.kind = OperandSyntax::Kind::direct;
    out.expression = expression();
    return out;
  }
  if (accept("=")) {
    out.exact = true;
    out.expression = expression();
    return out;
  }
  const std::size_t start = position_;
  if (const auto found = accept_register()) {
    out.kind = OperandSyntax::Kind::reg;
    out.reg = *found;
    return out;
  }
  if (const auto found = isa::expansion_named(identifier())) {
    out.kind = OperandSyntax::Kind::expansion;
    out.expansion = *found;
    return out;
  }
  position_ = start;
  out.expression = expression();
  return out;
}

OperandSyntax Parser::indirect() {
  using Action = isa::modn::Action;
  OperandSyntax out;
  out.kind = OperandSyntax::Kind::indirect;
  out.offset = position_;
  expect("*");
  skip_blanks();
  const int plus = accept("++") ? 2 : accept("--") ? -2 : accept("+") ? 1 : accept("-") ? -1 : 0;
  const std::size_t register_offset = position_;
  const auto ar = accept_register();
  if (!ar || isa::code(*ar) < 8 || isa::code(*ar) > 15)
    throw LineError{register_offset, "indirect addressing goes through AR0 to AR7"};
  out.reg = *ar;
  const std::size_t post_offset = position_;
  const int post = accept("++") ? 1 : accept("--") ? -1 : 0;
  if (plus != 0 && post != 0)
    throw LineError{post_offset, "an address register is changed either before or after its use, not both"};
  unsigned index = 0;
  const std::size_t amount_offset = position_;
  const bool amount = accept("(");
  if (amount) {
    const auto index_register = accept_register();
    if (index_register) {
      if (*index_register != isa::Register::IR0 && *index_register != isa::Register::IR1)
        throw LineError{amount_offset + 1, "the index is a displacement, IR0 or IR1"};
      index = *index_register == isa::Register::IR0 ? 1 : 2;
    } else {
      out.exact = accept("=");
      out.expression = expression();
    }
    expect(")");
  }
  const bool circular = peek() == '%';
  const bool reversed = (peek() == 'b' || peek() == 'B') && !is_identifier(peek(1));
  if (circular || reversed) {
    if (post == 0 || (reversed && (post != 1 || index != 1)))
      throw LineError{position_, circular ? "circular addressing has the form *ARn++(x)% or *ARn--(x)%"
                                          : "bit-reversed addressing has the form *ARn++(IR0)B"};
    ++position_;
  }
  if (reversed) {
    out.modn = isa::modn::bit_reversed;
    return out;
  }
  if (plus == 0 && post == 0) {
    if (amount) throw LineError{amount_offset, "*ARn takes no index; write *+ARn(x) or *ARn++(x)"};
    out.modn = isa::modn::plain;
    return out;
  }
  const Action action = post > 0     ? (circular ? Action::post_add_circular : Action::post_add)
                        : post < 0   ? (circular ? Action::post_subtract_circular : Action::post_subtract)
                        : plus == 2  ? Action::pre_add
                        : plus == -2 ? Action::pre_subtract
                        : plus == 1  ? Action::add
                                     : Action::subtract;
  out.modn = static_cast<std::uint8_t>(index << 3 | static_cast<unsigned>(action));
  return out;
}

HalfSyntax Parser::half() {
  HalfSyntax out;
  skip_blanks();
  out.offset = position_;
  out.mnemonic = lower(required_identifier("an instruction"));
  if (at_end() || at_bars()) return out;
  do out.operands.push_back(operand());
  while (accept(","));
  return out;
}

}  // namespace toolchain
