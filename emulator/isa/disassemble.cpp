#include "isa/disassemble.hpp"

#include <fmt/format.h>

#include <cmath>

namespace isa {
namespace {

using Kind = Operand::Kind;

std::string indirect_text(const Operand& operand, bool exact) {
  const auto ar = name(operand.reg);
  if (operand.modn == modn::plain) return fmt::format("*{}", ar);
  if (operand.modn == modn::bit_reversed) return fmt::format("*{}++(ir0)b", ar);
  const auto index = modn::index(operand.modn);
  const std::string amount = index == modn::Index::displacement ? fmt::format("{}{}", exact ? "=" : "", operand.value)
                             : index == modn::Index::IR0        ? "ir0"
                                                                : "ir1";
  switch (modn::action(operand.modn)) {
    case modn::Action::add: return fmt::format("*+{}({})", ar, amount);
    case modn::Action::subtract: return fmt::format("*-{}({})", ar, amount);
    case modn::Action::pre_add: return fmt::format("*++{}({})", ar, amount);
    case modn::Action::pre_subtract: return fmt::format("*--{}({})", ar, amount);
    case modn::Action::post_add: return fmt::format("*{}++({})", ar, amount);
    case modn::Action::post_subtract: return fmt::format("*{}--({})", ar, amount);
    case modn::Action::post_add_circular: return fmt::format("*{}++({})%", ar, amount);
    case modn::Action::post_subtract_circular: return fmt::format("*{}--({})%", ar, amount);
  }
  return {};
}

/// The format has one zero only. The other patterns with its exponent are 0 too, but no decimal number gives them.
bool has_decimal_form(Word bits) { return (bits >> 12) != 8 || bits == 0x8000; }

std::string short_float_text(Word bits) {
  if (!has_decimal_form(bits)) return fmt::format("={:#06x}", bits);
  if (bits == 0x8000) return "0.0";
  const int exponent = static_cast<int>(bits >> 12) - ((bits >> 12) >= 8 ? 16 : 0);
  const double fraction = static_cast<double>(bits & 0x7FF) / 2048.0;
  const double mantissa = ((bits & 0x800) != 0 ? -2.0 : 1.0) + fraction;
  std::string text = fmt::format("{}", std::ldexp(mantissa, exponent));
  if (text.find('.') == std::string::npos) text += ".0";
  return text;
}

class Printer {
 public:
  Printer(const Instruction& instruction, Address pc, const SymbolLookup& symbols, Cpu cpu)
      : in_(instruction), row_(*instruction.row), pc_(pc), symbols_(symbols), cpu_(cpu) {}

  std::string text() const {
    std::string out = first_half();
    if (row_.parallel()) out += " || " + second_half();
    return out;
  }

 private:
  std::string mnemonic() const {
    std::string text(row_.mnemonic);
    if (const auto place = text.find('?'); place != std::string::npos) text.replace(place, 1, name(in_.condition));
    return text;
  }

  /// LDM has a mantissa alone; an exponent beside it has no decimal form there.
  std::string float_text(Word bits) const {
    const bool has_exponent = row_.operation == Operation::ldm && (bits & 0xF000) != 0;
    return has_exponent ? fmt::format("={:#06x}", bits) : short_float_text(bits);
  }

  std::string operand(const Operand& o, bool exact = false) const {
    switch (o.kind) {
      case Kind::none: return {};
      case Kind::reg: return std::string(name(o.reg, cpu_));
      case Kind::direct: return fmt::format("@{:#x}", o.value);
      case Kind::indirect: return indirect_text(o, exact || (o.slot == Slot::none && o.modn == 0 && o.value == 0));
      case Kind::immediate_int: return fmt::format("{}", o.value);
      case Kind::immediate_float: return float_text(static_cast<Word>(o.value));
      case Kind::expansion: return std::string(name(static_cast<Expansion>(o.value)));
      case Kind::trap: return fmt::format("{}", o.value);
      case Kind::target:
      case Kind::address: {
        const Address address = (o.is(Kind::target) ? pc_ : 0) + static_cast<Word>(o.value);
        std::string symbol = symbols_ ? symbols_(address) : std::string();
        return symbol.empty() ? fmt::format("{:#x}", address) : symbol;
      }
    }
    return {};
  }

  /// A type-2 word whose indirect operands fit type 1 too needs a mark, so that it assembles to type 2 again.
  bool type1_would_do() const {
    if (row_.format != Format::three_type2 || in_.src2.is(Kind::immediate_int)) return false;
    return in_.src2.value <= 1 && (in_.src1.is(Kind::reg) || in_.src1.value <= 1);
  }

  std::string sources_then(const Operand& last) const {
    std::string out = mnemonic() + " " + operand(in_.src2, type1_would_do()) + "," + operand(in_.src1);
    if (!last.is(Kind::none)) out += "," + operand(last);
    if (const Word unused = row_.bits.field('z').get(in_.word); unused != 0) out += fmt::format(",={}", unused);
    return out;
  }

  std::string join(const Operand& a, const Operand& b) const {
    return fmt::format("{} {},{}", mnemonic(), operand(a), operand(b));
  }
  std::string join(const Operand& a) const { return fmt::format("{} {}", mnemonic(), operand(a)); }

  std::string first_half() const {
    switch (row_.format) {
      case Format::plain: return mnemonic();
      case Format::binary: return join(in_.src2, in_.dst);
      case Format::compare: return join(in_.src2, in_.src1);
      case Format::source:
      case Format::register_source:
      case Format::load_page:
      case Format::branch_displacement:
      case Format::branch_register:
      case Format::branch_absolute:
      case Format::trap: return join(in_.src1);
      case Format::register_destination:
      case Format::register_both: return join(in_.dst);
      case Format::three_type1:
      case Format::three_type2:
      case Format::op3_store:
      case Format::op3_store_reversed:
      case Format::multiply_add: return sources_then(in_.dst);
      case Format::decrement_displacement:
      case Format::decrement_register: return join(in_.dst, in_.src1);
      default: return join(in_.src1, in_.dst);
    }
  }

  std::string second_half() const {
    if (row_.format == Format::multiply_add)
      return fmt::format("{} {},{},{}", row_.mnemonic2, operand(in_.src4), operand(in_.src3), operand(in_.dst2));
    return fmt::format("{} {},{}", row_.mnemonic2, operand(in_.src3), operand(in_.dst2));
  }

  const Instruction& in_;
  const Row& row_;
  Address pc_;
  const SymbolLookup& symbols_;
  Cpu cpu_;
};

}  // namespace

std::string disassemble(const Instruction& instruction, Address pc, const SymbolLookup& symbols, Cpu cpu) {
  return Printer(instruction, pc, symbols, cpu).text();
}

std::string disassemble(Word word, Address pc, const SymbolLookup& symbols, Cpu cpu) {
  const Decoded decoded = decode(word, cpu);
  if (const auto* instruction = std::get_if<Instruction>(&decoded)) return disassemble(*instruction, pc, symbols, cpu);
  return fmt::format(".word {:#010x}", word);
}

}  // namespace isa
