// A relocation applied to a word.
#include "isa/decode.hpp"
#include "toolchain/encoder/operand_encoder.hpp"
#include "toolchain/linker/linker.hpp"

namespace toolchain {
namespace {

std::int64_t sign_extended(std::uint64_t value, unsigned bits) {
  const unsigned shift = 64 - bits;
  return static_cast<std::int64_t>(value << shift) >> shift;
}

/// The row of the instruction whose immediate the field is; null in other words.
const isa::Row* row_with_immediate(Word word) {
  const isa::Decoded decoded = isa::decode(word);
  const auto* instruction = std::get_if<isa::Instruction>(&decoded);
  const auto immediate = [](const isa::Operand& operand) { return operand.is(isa::Operand::Kind::immediate_int); };
  return instruction != nullptr && (immediate(instruction->src1) || immediate(instruction->src2)) ? instruction->row
                                                                                                  : nullptr;
}

}  // namespace

Relocated relocate(Word word, const Relocation& relocation, Word symbol_then, Word symbol_now, Word place_then,
                   Word place_now, bool symbol_is_section, bool is_address) {
  const unsigned bits = width(relocation.type);
  const auto mask = static_cast<Word>((std::uint64_t{1} << bits) - 1);
  const auto put = [&](std::int64_t value) { return (word & ~mask) | (static_cast<Word>(value) & mask); };
  if (relocation.type == RelocationType::partms16) {
    // Without a low half in the object: the low half of the symbol, if the high half belongs to it.
    Word low = relocation.low;
    if (low == 0 && symbol_then >> 16 == (word & mask)) low = symbol_then & 0xFFFF;
    const Word address = ((word & mask) << 16 | low) - symbol_then + symbol_now;
    return {put(address >> 16), true, address};
  }
  const Word origin_then = is_relative(relocation.type) ? place_then : 0;
  const Word origin_now = is_relative(relocation.type) ? place_now : 0;
  std::int64_t rest = sign_extended((word & mask) - symbol_then + origin_then, bits);
  // A place in a section is after its start; a branch subtracts 3 at most.
  if (symbol_is_section && is_relative(relocation.type) && rest < -3) rest += std::int64_t{1} << bits;
  const std::int64_t value = std::int64_t{symbol_now} + rest - std::int64_t{origin_now};
  // Distances may wrap around the end of the address space.
  const std::int64_t distance =
      is_relative(relocation.type) ? sign_extended(static_cast<std::uint64_t>(value), 32) : value;
  Relocated out{put(distance), true, distance};
  switch (relocation.type) {
    case RelocationType::pcrword:
    case RelocationType::pcr24:
      out.fits = distance >= -(std::int64_t{1} << (bits - 1)) && distance < std::int64_t{1} << (bits - 1);
      break;
    case RelocationType::rel24: out.fits = distance >= 0 && distance <= std::int64_t{mask}; break;
    case RelocationType::relword: {
      // As the assembler takes a number that it knows. Of other words any 16 bits will do.
      const std::int64_t number = sign_extended(static_cast<std::uint64_t>(value), 32);
      const isa::Row* const row = row_with_immediate(word);
      const Value::Half half = row != nullptr && is_address ? half_taken_by(row->operation) : Value::Half::none;
      if (half != Value::Half::none) {
        out.word = put(half == Value::Half::high ? number >> 16 : number);
        break;
      }
      if (!is_address) out.value = number;
      out.fits = number >= -32768 && number <= 65535 && (row == nullptr || immediate_takes(*row, number, is_address));
      break;
    }
    default: break;
  }
  return out;
}

}  // namespace toolchain
