#pragma once
// Expressions of the assembler: parsed once, evaluated when their symbols are known.
#include <cstdint>
#include <string>
#include <vector>

#include "toolchain/syntax/float_format.hpp"

namespace toolchain {

/// A number, an address in a section or relative to an external symbol, a half of such an address, or a float.
struct Value {
  enum class Kind : std::uint8_t { integer, real } kind = Kind::integer;
  std::int64_t integer = 0;
  /// If not absolute, `integer` counts from the start of that section, or from external symbol number -2 - section.
  int section = absolute;
  Real real;
  enum class Half : std::uint8_t {
    none,
    low,
    high
  } half = Half::none;  ///< The half of an address that is not assigned yet.

  static constexpr int absolute = -1;
  static constexpr int first_external = -2;
  static Value of(std::int64_t value) {
    return {.kind = Kind::integer, .integer = value, .section = absolute, .real = {}, .half = Half::none};
  }
  static Value of(Real value) {
    return {.kind = Kind::real, .integer = 0, .section = absolute, .real = value, .half = Half::none};
  }
  static Value at(int section, std::int64_t offset) {
    return {.kind = Kind::integer, .integer = offset, .section = section, .real = {}, .half = Half::none};
  }
  static Value external(int number) { return at(first_external - number, 0); }
  bool is_real() const { return kind == Kind::real; }
  bool is_absolute() const { return section == absolute; }
  bool is_address() const { return !is_real() && !is_absolute(); }
  bool is_external() const { return section <= first_external; }
  int external_number() const { return first_external - section; }
};

struct Expression {
  enum class Kind : std::uint8_t { constant, symbol, unary, binary, call } kind = Kind::constant;
  Value value;                       ///< constant
  std::string name;                  ///< symbol, operator, function
  std::vector<Expression> operands;  ///< of operators and functions
  std::size_t offset = 0;            ///< in its line
};

/// Gives expressions their symbols and the addresses of sections.
class SymbolSource {
 public:
  virtual ~SymbolSource() = default;
  /// Throws LineError if there is no such symbol.
  virtual Value value_of(const std::string& name, std::size_t offset) const = 0;
  virtual bool is_defined(const std::string& name) const = 0;
  /// True once sections have addresses. Until then *, << and the like do not accept addresses, and hi16, lo16 give
  /// halves.
  virtual bool is_placed() const = 0;
  virtual std::int64_t address_of_section(int section) const = 0;
  /// The number that a value, not a float, is once sections have addresses. An address has 32 bits, and wraps.
  std::int64_t number_of(const Value& value) const;
};

/// Throws LineError. Integers are 64 bits wide; comparisons give 1 or 0.
Value evaluate(const Expression& expression, const SymbolSource& symbols);

}  // namespace toolchain
