#include "machine/debug/expression.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>

#include "c40/peripherals/register_map.hpp"
#include "c40/values/float40.hpp"
#include "isa/ascii.hpp"
#include "isa/types.hpp"
#include "toolchain/objects/written_integer.hpp"

namespace machine::debug {

std::string Value::text() const {
  if (is_float) return fmt::format("{:.9g}", real);
  if (is_word())
    return fmt::format("{} ({:08X}h)", static_cast<std::int32_t>(static_cast<std::uint32_t>(integer)),
                       static_cast<std::uint32_t>(integer));
  return fmt::format("{}", integer);
}

/// A node of the expression's tree.
struct Expression::Node {
  std::function<Value()> value;
  bool is_private = true;
  std::optional<isa::Register> reg;  ///< one of R0 to R11, for f()
};

namespace {

/// Thrown for a word that other chips can access, where only the chip's own words count.
struct NotOwn {};
thread_local bool only_own = false;

using NodePtr = std::unique_ptr<Expression::Node>;

Value of(std::int64_t integer) { return {.integer = integer}; }
Value of_word(Word word) { return {.integer = static_cast<std::int32_t>(word)}; }
Value of_register(Word word) { return {.integer = static_cast<std::int32_t>(word), .is_register = true}; }
Value of_counter(std::int64_t integer) { return {.integer = integer, .is_counter = true}; }
Value of_float(double real) { return {.is_float = true, .real = real}; }

/// 64-bit integers; overflow wraps.
std::int64_t wrapping(std::string_view op, std::int64_t a, std::int64_t b) {
  const auto x = static_cast<std::uint64_t>(a), y = static_cast<std::uint64_t>(b);
  if (op == "+") return static_cast<std::int64_t>(x + y);
  if (op == "-") return static_cast<std::int64_t>(x - y);
  if (op == "*") return static_cast<std::int64_t>(x * y);
  if (op == "&") return a & b;
  if (op == "|") return a | b;
  if (op == "^") return a ^ b;
  if (op == "<<") return b < 0 || b > 63 ? 0 : static_cast<std::int64_t>(x << y);
  if (op == ">>") return a >> std::clamp<std::int64_t>(b, 0, 63);
  if (b == 0) throw DebugError("a division by zero");
  if (b == -1) return op == "/" ? static_cast<std::int64_t>(-x) : 0;
  return op == "/" ? a / b : a % b;
}

Value apply(std::string_view op, const Value& a, const Value& b) {
  const bool real = a.is_float || b.is_float;
  if (op == "==" || op == "!=") {
    bool equal = a.number() == b.number();
    if (!real)
      equal = a.is_word() && b.is_word() ? static_cast<Word>(a.integer) == static_cast<Word>(b.integer)
                                         : a.integer == b.integer;
    return of(equal == (op == "=="));
  }
  const auto compare = [&](auto x, auto y) {
    return op == "<" ? x < y : op == "<=" ? x <= y : op == ">" ? x > y : x >= y;
  };
  if (op[0] == '<' || op[0] == '>')
    if (op != "<<" && op != ">>") return of(real ? compare(a.number(), b.number()) : compare(a.integer, b.integer));
  if (!real) return of(wrapping(op, a.integer, b.integer));
  if (op == "+") return of_float(a.number() + b.number());
  if (op == "-") return of_float(a.number() - b.number());
  if (op == "*") return of_float(a.number() * b.number());
  if (op == "/") return of_float(a.number() / b.number());
  throw DebugError(fmt::format("{} takes integers, and here is a float", op));
}

/// A number with a point or an exponent; without either it is a whole one, and too large.
std::optional<double> fraction(std::string_view token) {
  return token.find_first_of(".eE") != std::string_view::npos ? ascii::number<double>(token) : std::nullopt;
}

class Parser {
 public:
  Parser(std::string_view text, Debuggee& debuggee, const std::vector<ProgramView>& programs, std::size_t chip)
      : text_(text), debuggee_(debuggee), programs_(programs), chip_(chip) {}

  NodePtr whole() {
    NodePtr node = binary(0);
    skip();
    if (at_ != text_.size()) refuse("an operator or the end is expected");
    return node;
  }

 private:
  static constexpr int deepest = 100;

  [[noreturn]] void refuse(std::string_view what) const {
    throw DebugError(fmt::format("expression \"{}\", column {}: {}", text_, at_ + 1, what));
  }
  void skip() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
  }
  bool take(std::string_view token) {
    skip();
    if (!text_.substr(at_).starts_with(token)) return false;
    at_ += token.size();
    return true;
  }

  NodePtr binary(std::size_t level) {
    static const std::array<std::vector<std::string_view>, 10> levels{{{"||"},
                                                                       {"&&"},
                                                                       {"|"},
                                                                       {"^"},
                                                                       {"&"},
                                                                       {"==", "!="},
                                                                       {"<=", ">=", "<", ">"},
                                                                       {"<<", ">>"},
                                                                       {"+", "-"},
                                                                       {"*", "/", "%"}}};
    if (level == levels.size()) return unary();
    NodePtr left = binary(level + 1);
    for (;;) {
      const auto op = operator_of(levels[level]);
      if (op.empty()) return left;
      NodePtr right = binary(level + 1);
      left = joined(op, std::move(left), std::move(right));
    }
  }

  std::string_view operator_of(const std::vector<std::string_view>& level) {
    skip();
    const std::string_view rest = text_.substr(at_);
    for (const std::string_view op : level) {
      if (!rest.starts_with(op)) continue;
      if (op.size() == 1 && rest.size() > 1 && (op == "|" || op == "&" || op == "<" || op == ">") && rest[1] == op[0])
        continue;
      at_ += op.size();
      return op;
    }
    return {};
  }

  static NodePtr joined(std::string_view op, NodePtr a, NodePtr b) {
    auto node = std::make_unique<Expression::Node>();
    node->is_private = a->is_private && b->is_private;
    node->value = [op, a = std::shared_ptr<Expression::Node>(std::move(a)),
                   b = std::shared_ptr<Expression::Node>(std::move(b))] {
      if (op == "&&") return of(a->value().truth() && b->value().truth());
      if (op == "||") return of(a->value().truth() || b->value().truth());
      return apply(op, a->value(), b->value());
    };
    return node;
  }

  NodePtr unary() {
    if (++depth_ > deepest) refuse("nested too deep");
    NodePtr node;
    skip();
    const char c = at_ < text_.size() ? text_[at_] : 0;
    if (c == '-' || c == '!' || c == '~') {
      ++at_;
      auto inner = std::shared_ptr<Expression::Node>(unary());
      node = std::make_unique<Expression::Node>();
      node->is_private = inner->is_private;
      node->value = [c, inner] {
        const Value v = inner->value();
        if (c == '!') return of(!v.truth());
        if (v.is_float) {
          if (c == '~') throw DebugError("~ takes an integer, and here is a float");
          return of_float(-v.real);
        }
        return c == '-' ? of(wrapping("-", 0, v.integer)) : of(~v.integer);
      };
    } else {
      node = primary();
    }
    --depth_;
    return node;
  }

  NodePtr primary() {
    skip();
    if (take("(")) {
      NodePtr inner = binary(0);
      if (!take(")")) refuse(") is expected");
      return inner;
    }
    if (take("[")) return memory();
    if (at_ == text_.size()) refuse("a value is expected: a number, a register, a label, [address]");
    const char c = text_[at_];
    if (c >= '0' && c <= '9') return number();
    if (ascii::is_letter(c) || c == '_' || c == '$') return named();
    refuse("a value is expected: a number, a register, a label, [address]");
  }

  NodePtr memory() {
    auto inner = std::shared_ptr<Expression::Node>(binary(0));
    if (!take("]")) refuse("] is expected");
    auto node = std::make_unique<Expression::Node>();
    Debuggee& debuggee = debuggee_;
    const std::size_t chip = chip_;
    node->is_private = inner->is_private;
    node->value = [inner, &debuggee, chip] {
      const auto address = static_cast<Address>(inner->value().integer);
      if (only_own && debuggee.shared_word(chip, address)) throw NotOwn{};
      const auto word = debuggee.peek(chip, address);
      if (!word) throw DebugError(fmt::format("[{:08X}h]: nothing can be read there without a bus access", address));
      Value value = of_word(*word);
      value.address = address;
      return value;
    };
    return node;
  }

  NodePtr number() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (ascii::is_letter_or_digit(text_[at_]) || text_[at_] == '.' ||
                                  ((text_[at_] == '-' || text_[at_] == '+') &&
                                   (text_[at_ - 1] == 'e' || text_[at_ - 1] == 'E') && text_.substr(begin, 2) != "0x")))
      ++at_;
    const std::string_view token = text_.substr(begin, at_ - begin);
    auto node = std::make_unique<Expression::Node>();
    const auto integer = toolchain::written_integer(token);
    const auto real = integer ? std::nullopt : fraction(token);
    if ((!integer && !real) || (integer && *integer > std::numeric_limits<std::int64_t>::max()))
      at_ = begin,
      refuse(fmt::format("{} is not a number; 12, 0Ch, 0xC, of 64 bits at the most, or 1.5 is expected", token));
    const Value written = integer ? of(static_cast<std::int64_t>(*integer)) : of_float(*real);
    node->value = [written] { return written; };
    return node;
  }

  NodePtr named() {
    const std::size_t begin = at_;
    while (at_ < text_.size() &&
           (ascii::is_letter_or_digit(text_[at_]) || text_[at_] == '_' || text_[at_] == '.' || text_[at_] == '$'))
      ++at_;
    const std::string name(text_.substr(begin, at_ - begin));
    if ((name == "f" || name == "u") && take("(")) return converted(name[0]);
    if (NodePtr node = of_chip(name, chip_)) return node;
    if (const std::size_t dot = name.find('.'); dot != std::string::npos)
      for (const std::string_view prefix : {"dsp", "chip"})
        if (name.starts_with(prefix)) {
          const std::string digits = name.substr(prefix.size(), dot - prefix.size());
          const auto n = ascii::number<std::size_t>(digits);
          if (!n || digits.size() > 2) continue;
          if (*n >= debuggee_.chips())
            at_ = begin,
            refuse(fmt::format("there is no {} {}; 0 to {} are possible", prefix, *n, debuggee_.chips() - 1));
          if (NodePtr node = of_chip(name.substr(dot + 1), *n)) {
            node->is_private = node->is_private && *n == chip_;
            if (*n != chip_)
              node->value = [value = std::move(node->value), n = *n] {
                Value of_another = value();
                of_another.chip = n;
                return of_another;
              };
            return node;
          }
        }
    if (debuggee_.value(name)) {
      auto node = std::make_unique<Expression::Node>();
      node->is_private = false;
      node->value = [&debuggee = debuggee_, name] { return of_float(debuggee.value(name).value_or(0)); };
      return node;
    }
    at_ = begin;
    refuse(fmt::format("{} is not a register, label, peripheral register or value", name));
  }

  NodePtr converted(char how) {
    auto inner = std::shared_ptr<Expression::Node>(binary(0));
    if (!take(")")) refuse(") is expected");
    auto node = std::make_unique<Expression::Node>();
    node->is_private = inner->is_private;
    if (how == 'f' && inner->reg) {
      node->value = [chip = &debuggee_.chip(chip_), reg = *inner->reg] {
        return of_float(c40::float40::to_double(chip->float_register(reg)));
      };
      return node;
    }
    node->value = [inner, how] {
      const Value v = inner->value();
      if (v.is_float) return v;
      const auto word = static_cast<Word>(v.integer);
      return how == 'u' ? of(word) : of_float(c40::float40::to_double(c40::float40::from_single(word)));
    };
    return node;
  }

  /// A register, label or counter of a chip; null if the name is unknown.
  NodePtr of_chip(std::string name, std::size_t n) {
    c40::Chip& chip = debuggee_.chip(n);
    auto node = std::make_unique<Expression::Node>();
    if (const auto reg = isa::register_named(name)) {
      if (isa::is_extended(*reg) && (name[0] == 'f' || name[0] == 'F')) {
        node->value = [&chip, reg = *reg] { return of_float(c40::float40::to_double(chip.float_register(reg))); };
        return node;
      }
      node->reg = isa::is_extended(*reg) && n == chip_ ? reg : std::nullopt;
      node->value = [&chip, reg = *reg] { return of_register(static_cast<Word>(chip.register_value(reg))); };
      return node;
    }
    if (const auto expansion = isa::expansion_named(name)) {
      node->value = [&chip, e = *expansion] { return of_register(chip.expansion(e)); };
      return node;
    }
    const std::string lower = ascii::lower(name);
    if (lower == "pc")
      node->value = [&chip] { return Value{.integer = chip.pc(), .is_register = true}; };
    else if (lower == "cycle")
      node->value = [&chip] { return of_counter(chip.cycle()); };
    else if (lower == "instructions")
      node->value = [&chip] { return of_counter(static_cast<std::int64_t>(chip.instructions())); };
    else if (lower == "time_s")
      node->is_private = false,
      node->value = [&d = debuggee_] { return of_float(static_cast<double>(d.now().count()) * 1e-12); };
    else if (const auto cause = cause_named(lower))
      node->value = [&chip, i = *cause] { return of_counter(chip.causes()[i]); };
    else if (const auto label = programs_.at(n).address(name)) {
      node->value = [word = *label] {
        Value value = of(word);
        value.address = word;
        return value;
      };
    } else if (const auto address = peripheral_named(name)) {
      node->value = [&chip, address = *address] {
        Value value = of_word(chip.peek(address));
        value.address = address;
        return value;
      };
    } else {
      return nullptr;
    }
    return node;
  }

  /// "cause.bus_transfer": the chip's cycles with that cause.
  static std::optional<std::size_t> cause_named(std::string_view name) {
    for (std::size_t i = 0; i < c40::cause_count; ++i)
      if (name.starts_with("cause.") && name.substr(6) == c40::name(static_cast<c40::Cause>(i))) return i;
    return std::nullopt;
  }

  static std::optional<Address> peripheral_named(const std::string& name) {
    if (name.find('.') == std::string::npos) return std::nullopt;
    try {
      return c40::register_named(name).address;
    } catch (const std::out_of_range&) {
      return std::nullopt;
    }
  }

  std::string_view text_;
  Debuggee& debuggee_;
  const std::vector<ProgramView>& programs_;
  std::size_t chip_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

Expression::Expression(std::string_view text, Debuggee& debuggee, const std::vector<ProgramView>& programs,
                       std::size_t chip)
    : root_(Parser(text, debuggee, programs, chip).whole()) {}
Expression::~Expression() = default;
Expression::Expression(Expression&&) noexcept = default;
Expression& Expression::operator=(Expression&&) noexcept = default;
Value Expression::value() const { return root_->value(); }
std::optional<Value> Expression::own_value() const {
  if (!root_->is_private) return std::nullopt;
  only_own = true;
  try {
    const Value value = root_->value();
    only_own = false;
    return value;
  } catch (const NotOwn&) {
    only_own = false;
    return std::nullopt;
  } catch (...) {
    only_own = false;
    throw;
  }
}

Address word_named(std::string_view text, Debuggee& debuggee, const std::vector<ProgramView>& programs,
                   std::size_t chip, bool by_register) {
  if (const auto labelled = programs.at(chip).labelled(text)) return *labelled;
  const Value value = Expression(text, debuggee, programs, chip).value();
  if (value.chip)
    throw DebugError(fmt::format("{} is of {}, and a place is one of {}: choose the chip by its number", text,
                                 debuggee.chip_name(*value.chip), debuggee.chip_name(chip)));
  if (value.address) return *value.address;
  if (value.is_register && !by_register)
    throw DebugError(fmt::format("{} is a register, not a place; the word to which it points is [{}]", text, text));
  if (value.is_counter)
    throw DebugError(fmt::format("{} is a counter, not a place; a label, 300000h or [address] is expected", text));
  if (!value.is_word()) throw DebugError(fmt::format("{} is not an address: 32 bits are", text));
  return static_cast<Address>(value.integer);
}

std::string filled_in(std::string_view text, Debuggee& debuggee, const std::vector<ProgramView>& programs,
                      std::size_t chip) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t open = text.find('{', at), close = open == std::string_view::npos ? open : text.find('}', open);
    if (close == std::string_view::npos) return out + std::string(text.substr(at));
    out += text.substr(at, open - at);
    try {
      out += Expression(text.substr(open + 1, close - open - 1), debuggee, programs, chip).value().text();
    } catch (const std::exception& error) {
      out += fmt::format("<{}>", error.what());
    }
    at = close + 1;
  }
  return out;
}

}  // namespace machine::debug
