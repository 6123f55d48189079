#pragma once
// Encodes one operand into the fields of one row.
#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "isa/table.hpp"
#include "toolchain/encoder/encoder.hpp"
#include "toolchain/encoder/mnemonics.hpp"

namespace toolchain {

/// A row that does not fit; the user gets the message of the row that fits best.
struct Mismatch {
  enum Rank : std::uint8_t { count, kind, contents } rank;
  LineError error;
};

/// "the register r0", "a number or label"...
std::string kind_text(const OperandSyntax& operand, isa::Cpu cpu);
bool fits_signed(std::int64_t value, unsigned bits);
bool fits_unsigned(std::int64_t value, unsigned bits);
/// Only these take the low half of an address alone: an instruction for the high half comes before or behind them.
bool is_logical(isa::Operation operation);
/// The half of an address that an instruction with an immediate takes, or none. A constant is a number for all of them.
Value::Half half_taken_by(isa::Operation operation);
/// Whether an instruction with an immediate takes the number in its 16 bits. An address has to be the immediate's
/// value; a constant may also be given as the 16 bits themselves, where the row does not count from 0.
bool immediate_takes(const isa::Row& row, std::int64_t number, bool is_address);

/// The present statement as one row sees it: its halves, and the bits of its operands. All functions throw Mismatch if
/// the row does not take the operand, and LineError if the operand itself is wrong (an undefined symbol).
class OperandEncoder {
 public:
  OperandEncoder(const Candidate& candidate, const HalfSyntax& first, const HalfSyntax* second,
                 const EncodeContext& context);

  /// A page number, or the page of an address. A number is a page; a label, or anything with an at sign, is an address.
  isa::Word page(const OperandSyntax& operand) const;
  /// The page of an address, which may be a number too. Warns about a number that could be meant as a page.
  isa::Word page_of_address(const OperandSyntax& operand) const;

  /// Passes the relocations to the context, once the row is known to fit.
  void note_relocations() const;

 protected:
  using Kind = OperandSyntax::Kind;
  using Word = isa::Word;

  [[noreturn]] void miss(Mismatch::Rank rank, std::size_t offset, std::string message) const;

  const HalfSyntax& half() const { return *halves_[static_cast<std::size_t>(half_)]; }
  const std::vector<OperandSyntax>& operands() const { return half().operands; }
  const OperandSyntax& operand(std::size_t i) const { return operands()[i]; }
  void need(std::size_t count) const;  ///< Exactly this number of operands.
  void need_kind(const OperandSyntax& operand, Kind kind, std::string_view wanted) const;

  Value value(const OperandSyntax& operand) const;
  /// A number. An address is not a number in a relocatable object.
  std::int64_t integer(const OperandSyntax& operand, const Value& value) const;
  /// A number, or the known part of an address; a relocation of this type is noted for the rest.
  std::int64_t address(const OperandSyntax& operand, const Value& value, RelocationType type) const;
  /// The half that the source asks for, or `otherwise`, in a field of 16 bits.
  Word half_of_address(const OperandSyntax& operand, const Value& value, Value::Half otherwise) const;
  void need_whole(const OperandSyntax& operand, const Value& value) const;  ///< No half of an address.
  /// Whether the linker finds out if the symbol of another object is an address, of which it puts the half that the
  /// instruction takes, or a number. GNU as has one relocation for both, that of an address.
  bool linker_decides(const Value& value) const;
  /// The field of an immediate for another object's symbol.
  Word number_or_address(const OperandSyntax& operand, const Value& value) const;
  std::int64_t integer(const OperandSyntax& operand) const { return integer(operand, value(operand)); }
  Word in_range(const OperandSyntax& operand, std::int64_t number, bool fits, std::string_view range) const;

  bool is_register(const OperandSyntax& operand) const;
  Word register_code(const OperandSyntax& operand, isa::OperandClass allowed) const;
  Word low_register(const OperandSyntax& operand) const;  ///< R0 to R7.
  Word expansion_code(const OperandSyntax& operand) const;

  std::int64_t displacement(const OperandSyntax& operand) const;
  Word direct_field(const OperandSyntax& operand) const;
  Word indirect_field(const OperandSyntax& operand) const;  ///< The 16-bit form.
  /// The 8-bit form, whose displacement can only be 1. \param refusal of another one
  Word byte(const OperandSyntax& operand,
            std::string_view refusal = "the displacement can only be 1 in this instruction") const;
  Word immediate(const OperandSyntax& operand) const;  ///< 16 bits.

  const isa::Row& row_;
  const EncodeContext& context_;
  int half_ = 0;  ///< The present half, in the row's order.
  mutable std::vector<FieldRelocation> relocations_;

 private:
  Word short_float(const OperandSyntax& operand, const Value& value) const;
  Word page_that_exists(const OperandSyntax& operand, std::int64_t page) const;

  std::array<const HalfSyntax*, 2> halves_{};
  bool exchanged_;
};

}  // namespace toolchain
