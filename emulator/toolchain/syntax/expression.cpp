#include "toolchain/syntax/expression.hpp"

#include <fmt/format.h>

#include <string_view>

#include "toolchain/syntax/diagnostics.hpp"

namespace toolchain {
namespace {

/// Evaluates each node once: an operand that was evaluated twice would cost two to the power of its depth.
class Evaluator {
 public:
  explicit Evaluator(const SymbolSource& symbols) : symbols_(symbols) {}

  Value operator()(const Expression& e) const {
    switch (e.kind) {
      case Expression::Kind::constant: return e.value;
      case Expression::Kind::symbol: return symbols_.value_of(e.name, e.offset);
      case Expression::Kind::unary: return unary(e);
      case Expression::Kind::binary: return binary(e);
      case Expression::Kind::call: return call(e);
    }
    return {};
  }

 private:
  /// An address as a plain number: allowed once the sections have addresses.
  std::int64_t number(const Expression& e, const Value& value) const {
    if (value.is_real()) throw LineError{e.offset, "an integer is needed here, not a float"};
    if (value.is_absolute()) return value.integer;
    if (!symbols_.is_placed())
      throw LineError{e.offset,
                      "an address cannot be used here: it is not assigned yet (only address + number, "
                      "address - number, address - address of one section, hi16 and lo16 can be)"};
    return symbols_.number_of(value);
  }

  Real real(const Expression& e, const Value& value) const {
    return value.is_real() ? value.real : real_of(number(e, value));
  }

  static Value half(Value address, Value::Half which) {
    address.half = which;
    return address;
  }

  Value unary(const Expression& e) const {
    const Expression& operand = e.operands[0];
    const Value value = (*this)(operand);
    if (e.name == "-" && value.is_real()) return Value::of(-value.real);
    const std::int64_t x = number(operand, value);
    if (e.name == "-") return Value::of(negated(x));
    if (e.name == "~") return Value::of(~x);
    return Value::of(std::int64_t{x == 0});
  }

  static std::int64_t negated(std::int64_t x) { return static_cast<std::int64_t>(0 - static_cast<std::uint64_t>(x)); }

  Value binary(const Expression& e) const {
    const Value a = (*this)(e.operands[0]), b = (*this)(e.operands[1]);
    if (a.is_real() || b.is_real()) return float_operation(e, a, b);
    if (a.half != Value::Half::none || b.half != Value::Half::none)
      throw LineError{e.offset, "half of an address that is not assigned yet cannot be part of an expression"};
    if (!symbols_.is_placed() && !a.is_absolute() && b.is_absolute()) {
      if (e.name == ">>" && b.integer == 16) return half(a, Value::Half::high);
      if (e.name == "&" && b.integer == 0xFFFF) return half(a, Value::Half::low);
    }
    if (e.name == "+" && (a.is_absolute() || b.is_absolute()))
      return Value::at(a.is_absolute() ? b.section : a.section, wrap_add(a.integer, b.integer));
    if (e.name == "-") {
      if (b.is_absolute()) return Value::at(a.section, wrap_add(a.integer, negated(b.integer)));
      if (a.section == b.section) return Value::of(wrap_add(a.integer, negated(b.integer)));
    }
    return Value::of(integer_operation(e, number(e.operands[0], a), number(e.operands[1], b)));
  }

  static std::int64_t wrap_add(std::int64_t a, std::int64_t b) {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
  }

  Value float_operation(const Expression& e, const Value& left, const Value& right) const {
    const double a = real(e.operands[0], left).nearest, b = real(e.operands[1], right).nearest;
    if (e.name == "+") return Value::of(Real(a + b));
    if (e.name == "-") return Value::of(Real(a - b));
    if (e.name == "*") return Value::of(Real(a * b));
    if (e.name == "/") {
      if (b == 0) throw LineError{e.offset, "division by zero"};
      return Value::of(Real(a / b));
    }
    if (e.name == "<") return Value::of(std::int64_t{a < b});
    if (e.name == ">") return Value::of(std::int64_t{a > b});
    if (e.name == "<=") return Value::of(std::int64_t{a <= b});
    if (e.name == ">=") return Value::of(std::int64_t{a >= b});
    if (e.name == "==" || e.name == "=") return Value::of(std::int64_t{a == b});
    if (e.name == "!=") return Value::of(std::int64_t{a != b});
    throw LineError{e.offset, fmt::format("'{}' takes integers, not floats", e.name)};
  }

  static std::int64_t integer_operation(const Expression& e, std::int64_t a, std::int64_t b) {
    const auto ua = static_cast<std::uint64_t>(a), ub = static_cast<std::uint64_t>(b);
    const std::string_view op = e.name;
    if (op == "+") return static_cast<std::int64_t>(ua + ub);
    if (op == "-") return static_cast<std::int64_t>(ua - ub);
    if (op == "*") return static_cast<std::int64_t>(ua * ub);
    if (op == "/" || op == "%") {
      if (b == 0) throw LineError{e.offset, "division by zero"};
      if (b == -1) return op == "/" ? negated(a) : 0;
      return op == "/" ? a / b : a % b;
    }
    if (op == "<<" || op == ">>") {
      if (b < 0 || b > 63) throw LineError{e.offset, "a shift count must be 0 to 63"};
      return op == "<<" ? static_cast<std::int64_t>(ua << b) : a >> b;
    }
    if (op == "&") return a & b;
    if (op == "|") return a | b;
    if (op == "^") return a ^ b;
    if (op == "<") return a < b;
    if (op == ">") return a > b;
    if (op == "<=") return a <= b;
    if (op == ">=") return a >= b;
    if (op == "!=") return a != b;
    if (op == "&&") return a != 0 && b != 0;
    return a == b;
  }

  Value call(const Expression& e) const {
    const Expression& argument = e.operands[0];
    const Value value = (*this)(argument);
    if (e.name == "single") {
      const auto word = to_single(real(argument, value));
      if (!word) throw LineError{e.offset, "out of the range of a 32-bit float"};
      return Value::of(std::int64_t{*word});
    }
    const bool prefix = e.name == "^" || e.name == "#";  // for a constant: the constant itself
    if (prefix && (value.is_real() || value.is_absolute())) return value;
    const auto which = e.name == "lo16" || e.name == "#" ? Value::Half::low : Value::Half::high;  // high: hi16, page
    if (!symbols_.is_placed() && !value.is_real() && !value.is_absolute() && value.half == Value::Half::none)
      return half(value, which);
    const std::int64_t address = number(argument, value);
    return Value::of((which == Value::Half::low ? address : address >> 16) & 0xFFFF);
  }

  const SymbolSource& symbols_;
};

}  // namespace

std::int64_t SymbolSource::number_of(const Value& value) const {
  if (value.is_absolute()) return value.integer;
  const auto address = static_cast<std::uint32_t>(address_of_section(value.section) + value.integer);
  switch (value.half) {
    case Value::Half::low: return address & 0xFFFF;
    case Value::Half::high: return address >> 16;
    case Value::Half::none: break;
  }
  return address;
}

Value evaluate(const Expression& expression, const SymbolSource& symbols) { return Evaluator(symbols)(expression); }

}  // namespace toolchain
