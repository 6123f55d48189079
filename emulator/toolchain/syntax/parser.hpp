#pragma once
// Splits one line of assembler source into its parts (c40-isa.md 11, docs/assembler.md).
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "isa/ascii.hpp"
#include "isa/decode.hpp"
#include "toolchain/syntax/diagnostics.hpp"
#include "toolchain/syntax/dialect.hpp"
#include "toolchain/syntax/expression.hpp"

namespace toolchain {

using ascii::is_digit;
using ascii::lower;

/// An operand in the source text. Its meaning depends on the instruction.
struct OperandSyntax {
  enum class Kind : std::uint8_t { reg, expansion, direct, indirect, expression } kind = Kind::expression;
  isa::Register reg = isa::Register::R0;  ///< For indirect: the ARn.
  isa::Expansion expansion = isa::Expansion::IVTP;
  std::uint8_t modn = 0;
  bool exact = false;                    ///< Marked by '=': exactly this value of the field.
  std::optional<Expression> expression;  ///< Of direct, expression; for indirect the displacement, if the text has one.
  std::size_t offset = 0;
};

struct HalfSyntax {
  std::string mnemonic;  ///< Lower case.
  std::string written;   ///< As in the source.
  std::vector<OperandSyntax> operands;
  std::size_t offset = 0;
};

/// Names that mean registers (`FP .set AR3`).
using RegisterNames = std::map<std::string, isa::Register, std::less<>>;

/// The symbols, the value of '$', the suffixes that make local labels unique, and further names of registers.
struct ParseContext {
  const SymbolSource* symbols = nullptr;  ///< What is defined so far.
  Value here;
  std::string local_suffix;  ///< Of names ending in '?'.
  std::string block_suffix;  ///< Of $0 to $9.
  const RegisterNames* registers = nullptr;
  Dialect dialect = Dialect::ti;
  std::vector<LineError>* warnings = nullptr;  ///< For text that has a meaning, perhaps not the intended one.
  isa::Cpu cpu = isa::Cpu::c40;
};

bool is_identifier_start(char c);
bool is_identifier(char c);
/// Number of characters of the character constant at the text's beginning, quotes included; 0: there is none.
std::size_t character_constant(std::string_view text);
/// How the whole text writes an integer, with the numbers that TI's $iscons has for it.
enum class ConstantKind : std::uint8_t { none, binary, octal, hexadecimal, character, decimal };
ConstantKind constant_kind(std::string_view text);
/// The line without its comment. A comment begins with ';' outside quotes, or is the whole line if it starts with '*'.
/// For GNU as the whole line is also a comment if its first character other than a blank is '#', as in the output of a
/// preprocessor.
std::string_view without_comment(std::string_view line, Dialect dialect);

/// Reads a line from left to right. Errors are LineErrors at offsets of that line.
class Parser {
 public:
  /// Takes the line up to its comment.
  Parser(std::string_view line, ParseContext context);

  void skip_blanks();
  bool at_end();
  std::size_t offset() const { return position_; }
  void seek(std::size_t offset) { position_ = offset; }
  char peek(std::size_t ahead = 0) const { return position_ + ahead < text_.size() ? text_[position_ + ahead] : '\0'; }
  bool starts_with(std::string_view token) const { return text_.substr(position_).starts_with(token); }
  bool accept(std::string_view token);  ///< Skips blanks, then the token if it is there.
  void expect(std::string_view token);
  void expect_end();

  /// As in the source, with local labels made unique; empty if there is none here.
  std::string identifier();
  std::string required_identifier(std::string_view what);
  std::string quoted();  ///< A string in double quotes, with "" for a quote and C's escapes.
  /// A file or section name, with or without quotes.
  std::string name_or_quoted(std::string_view what);
  std::string_view rest() const { return text_.substr(position_); }
  std::string_view next_word();  ///< The next identifier, if there is one; it stays unread.

  /// The register named here, if there is one and only blanks or a comma follow.
  std::optional<isa::Register> lone_register();
  Expression expression();
  std::vector<Expression> expression_list();
  HalfSyntax half();
  bool at_bars();  ///< Whether "||" is next.

 private:
  std::pair<int, std::string_view> operator_ahead(int loosest);
  Expression binary_expression(int loosest);
  Expression unary_expression();
  Expression primary_expression();
  Expression number();
  std::optional<Real> prefixed_float();
  void count_operator(std::size_t offset);
  Expression character();
  void warn_of_octal(std::string_view word, std::size_t offset) const;
  Expression call(const std::string& function, std::size_t offset);
  OperandSyntax operand();
  bool accept_half_of_address(char mark);
  OperandSyntax indirect();
  std::optional<isa::Register> register_called(std::string_view name) const;
  std::optional<isa::Expansion> expansion_called(std::string_view name) const;
  std::optional<isa::Register> accept_register();

  std::string_view text_;
  std::size_t position_ = 0;
  int operators_ = 0;  ///< In the present expression.
  ParseContext context_;
};

}  // namespace toolchain
