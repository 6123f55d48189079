#include "toolchain/encoder/encoder.hpp"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <utility>

#include "toolchain/encoder/operand_encoder.hpp"

namespace toolchain {
namespace {

using isa::Format;
using isa::Immediate;
using isa::OperandClass;
using isa::Word;
using Kind = OperandSyntax::Kind;

std::string modes_text(isa::Modes modes) {
  static constexpr std::array<std::string_view, 4> names{"a register", "@address", "*ARn", "an immediate"};
  std::string out;
  for (unsigned mode = 0; mode < 4; ++mode) {
    if ((modes >> mode & 1) == 0) continue;
    if (!out.empty()) out += (modes >> (mode + 1)) == 0 ? " or " : ", ";
    out += names[mode];
  }
  return out;
}

constexpr std::string_view three_operand_indirect =
    "a three-operand instruction takes *+ARn(0..31), or any indirect form with a displacement of 1";

/// An attempt to encode a statement with one row.
class Attempt : public OperandEncoder {
 public:
  Attempt(const Candidate& candidate, const HalfSyntax& first, const HalfSyntax* second, const EncodeContext& context)
      : OperandEncoder(candidate, first, second, context), word_(row_.bits.match) {
    if (row_.conditional()) put('c', isa::code(candidate.condition));
  }

  Word encode() {
    switch (row_.format) {
      case Format::op3_store:
      case Format::op3_store_reversed:
      case Format::op2_store:
      case Format::load_load:
      case Format::store_store:
      case Format::multiply_add: parallel(); break;
      default: single(); break;
    }
    note_relocations();
    return word_;
  }

 private:
  void put(char field, Word value) { word_ |= row_.bits.field(field).put(value); }

  /// An address without any mark. GNU as reads the word at this address; TI's assembler takes it as a number.
  bool is_direct_in_gnu(const OperandSyntax& o) const {
    if (context_.dialect != Dialect::gnu || o.kind != Kind::expression || o.exact || (row_.modes >> 1 & 1) == 0)
      return false;
    const auto kind = o.expression->kind;
    if (kind == Expression::Kind::call || kind == Expression::Kind::constant) return false;
    const Value address = value(o);
    return !address.is_real() && !address.is_absolute() && address.half == Value::Half::none;
  }

  /// The operand that G selects.
  void general(const OperandSyntax& o) {
    if (is_direct_in_gnu(o)) {
      OperandSyntax direct = o;
      direct.kind = Kind::direct;
      return general(direct);
    }
    const unsigned mode = is_register(o) ? 0 : o.kind == Kind::direct ? 1 : o.kind == Kind::indirect ? 2 : 3;
    if ((row_.modes >> mode & 1) == 0 || (o.kind == Kind::expansion && mode != 0))
      miss(Mismatch::kind, o.offset,
           fmt::format("{} is needed here, not {}", modes_text(row_.modes), kind_text(o, context_.cpu)));
    put('g', mode);
    put('s', mode == 0   ? register_code(o, row_.source)
             : mode == 1 ? direct_field(o)
             : mode == 2 ? indirect_field(o)
                         : immediate(o));
  }

  // Formats

  void single() {
    switch (row_.format) {
      case Format::plain: return need(0);
      case Format::unary: return unary();
      case Format::binary:
      case Format::binary_reversed:
        need(2);
        general(operand(0));
        return put('d', register_code(operand(1), row_.destination));
      case Format::compare:
        need(2);
        general(operand(0));
        return put('d', register_code(operand(1), row_.source));
      case Format::source: need(1); return general(operand(0));
      case Format::store:
        need(2);
        put('d', register_code(operand(0), row_.source));
        return general(operand(1));
      case Format::store_constant: return store_constant();
      case Format::register_source: need(1); return put('d', register_code(operand(0), row_.source));
      case Format::register_destination:
      case Format::register_both: need(1); return put('d', register_code(operand(0), row_.destination));
      case Format::load_constant:
        need(2);
        need_kind(operand(0), Kind::expression, "a number");
        put('k', immediate(operand(0)));
        return put('d', register_code(operand(1), row_.destination));
      case Format::load_page: need(1); return put('k', page(operand(0)));
      case Format::three_type1:
      case Format::three_type2: return three();
      case Format::branch_displacement:
      case Format::branch_register: need(1); return target(operand(0));
      case Format::branch_absolute: need(1); return absolute_target(operand(0));
      case Format::decrement_displacement:
      case Format::decrement_register: return decrement();
      case Format::trap: {
        need(1);
        need_kind(operand(0), Kind::expression, "a trap number");
        const std::int64_t number = integer(operand(0));
        const unsigned width = row_.bits.field('k').width;
        return put('k', in_range(operand(0), number, fits_unsigned(number, width),
                                 fmt::format("a trap number is 0 to {}", (1U << width) - 1)));
      }
      case Format::from_expansion:
        need(2);
        put('r', expansion_code(operand(0)));
        return put('d', register_code(operand(1), row_.destination));
      default:  // to_expansion
        need(2);
        put('r', register_code(operand(0), row_.source));
        return put('d', expansion_code(operand(1)));
    }
  }

  /// Loading a register from itself has no use, so there is no short form.
  bool is_load() const {
    using enum isa::Operation;
    const auto op = row_.operation;
    return op == ldi || op == ldf || op == ldi_cond || op == ldf_cond || op == lda || op == lb || op == lbu ||
           op == lh || op == lhu;
  }

  void unary() {
    if (operands().size() != 1 || operand(0).kind != Kind::reg || is_load()) need(2);
    const OperandSyntax& destination = operands().back();
    general(operand(0));
    put('d', register_code(destination, row_.destination));
    if (row_.destination == OperandClass::lda && operand(0).kind == Kind::reg && operand(0).reg == destination.reg)
      miss(Mismatch::contents, operand(0).offset, "LDA cannot load a register from itself");
  }

  void store_constant() {
    need(2);
    need_kind(operand(0), Kind::expression, "a constant");
    const bool is_direct = row_.modes == 1;
    need_kind(operand(1), is_direct ? Kind::direct : Kind::indirect, "@address or *ARn");
    const std::int64_t number = integer(operand(0));
    put('k', in_range(operand(0), number, fits_signed(number, 5), "the constant of STIK is -16 to 15"));
    put('s', is_direct ? direct_field(operand(1)) : indirect_field(operand(1)));
  }

  void target(const OperandSyntax& o) {
    if (row_.format == Format::branch_register || row_.format == Format::decrement_register)
      return put('r', register_code(o, row_.source));
    const bool of_register = row_.conditional() || row_.mnemonic.starts_with("rptb");
    need_kind(o, Kind::expression, of_register ? "a label or a register" : "a label");
    const auto origin = static_cast<Word>(context_.pc + row_.selector);
    const unsigned width = row_.bits.field('v').width;
    const auto type = width == 24 ? RelocationType::pcr24 : RelocationType::pcrword;
    const auto distance = static_cast<std::int32_t>(static_cast<Word>(address(o, value(o), type)) - origin);
    if (relocations_.empty() && !fits_signed(distance, width))
      miss(Mismatch::contents, o.offset,
           fmt::format("the target is {} words away; this branch reaches {} bits", distance, width));
    put('v', static_cast<Word>(distance));
  }

  void absolute_target(const OperandSyntax& o) {
    need_kind(o, Kind::expression, "a label or an address");
    const std::int64_t place = address(o, value(o), RelocationType::rel24);
    const bool fits = !relocations_.empty() || fits_unsigned(place, 24);
    put('v', in_range(o, place, fits, "an address of the C3x is 0 to 0FFFFFFh"));
  }

  void decrement() {
    need(2);
    need_kind(operand(0), Kind::reg, "AR0 to AR7");
    const unsigned counter = isa::code(operand(0).reg);
    if (counter < 8 || counter > 15)
      miss(Mismatch::contents, operand(0).offset,
           fmt::format("DBcond counts in AR0 to AR7, not in {}", isa::name(operand(0).reg)));
    put('n', counter & 7);
    target(operand(1));
  }

  /// src2, src1[, dst]; without dst, src1 is also the destination.
  void three() {
    const bool writes = row_.has('d');
    const bool fills = row_.has('z') && operands().size() == 3 && operands().back().exact;
    if (!(writes && operands().size() == 2)) need(writes || fills ? 3 : 2);
    if (fills) {
      const std::int64_t number = integer(operands().back());
      put('z', in_range(operands().back(), number, fits_unsigned(number, 5), "=x is a field of 5 bits here"));
    }
    if (writes) put('d', register_code(operands().back(), row_.destination));
    const OperandSyntax &src2 = operand(0), &src1 = operand(1);
    if (row_.format == Format::three_type1) return type1(src1, src2);
    if (row_.commutative && !fits_type2(src1, src2) && fits_type2(src2, src1)) return type2(src2, src1);
    type2(src1, src2);
  }

  /// On the C40, type 2 takes more displacements than 1.
  Word type1_byte(const OperandSyntax& o) const {
    if (o.kind != Kind::indirect) return register_code(o, row_.source);
    return context_.cpu == isa::Cpu::c40 ? byte(o, three_operand_indirect) : byte(o);
  }

  void type1(const OperandSyntax& src1, const OperandSyntax& src2) {
    put('t', (src1.kind == Kind::indirect ? 1U : 0U) | (src2.kind == Kind::indirect ? 2U : 0U));
    put('i', type1_byte(src2));
    put('j', type1_byte(src1));
  }

  bool is_type2_indirect(const OperandSyntax& o) const {
    return o.kind == Kind::indirect &&
           (o.modn == isa::modn::plain || (o.modn == 0 && fits_unsigned(displacement(o), 5)));
  }

  bool fits_type2(const OperandSyntax& src1, const OperandSyntax& src2) const {
    const bool second = is_type2_indirect(src2) || (src2.kind == Kind::expression && row_.immediate != Immediate::none);
    return second && (src1.kind == Kind::reg || is_type2_indirect(src1));
  }

  Word type2_byte(const OperandSyntax& o) const {
    if (!is_type2_indirect(o))
      miss(o.kind == Kind::indirect ? Mismatch::contents : Mismatch::kind, o.offset,
           o.kind == Kind::indirect
               ? std::string(three_operand_indirect)
               : fmt::format("no encoding takes {} here; an immediate or *+ARn(x) can be the first operand only{}",
                             kind_text(o, context_.cpu),
                             row_.immediate == Immediate::none ? ", and float instructions take no immediate" : ""));
    const Word d = o.modn == isa::modn::plain ? 0 : static_cast<Word>(displacement(o));
    return d << 3 | (Word{isa::code(o.reg)} & 7);
  }

  void type2(const OperandSyntax& src1, const OperandSyntax& src2) {
    const bool constant = src2.kind == Kind::expression;
    if (src1.kind == Kind::expression)
      miss(Mismatch::contents, src1.offset, "an immediate can be the first operand only");
    put('t', (src1.kind == Kind::indirect ? 2U : 0U) | (constant ? 0U : 1U));
    put('j', src1.kind == Kind::indirect ? type2_byte(src1) : register_code(src1, row_.source));
    if (!constant) return put('i', type2_byte(src2));
    if (row_.immediate == Immediate::none)
      miss(Mismatch::contents, src2.offset, "float instructions with three operands take no immediate");
    const std::int64_t number = integer(src2);
    put('i',
        in_range(src2, number, fits_signed(number, 8), "an immediate of three-operand instructions is -128 to 127") &
            255);
  }

  // Parallel formats

  /// Operand i of the present half; without a destination, the last source is also the destination.
  const OperandSyntax& of_three(std::size_t i) const {
    if (operands().size() == 2) return operand(i == 0 ? 0 : 1);
    need(3);
    return operand(i);
  }

  void store_half() {
    half_ = 1;
    need(2);
    put('e', low_register(operand(0)));
    put('j', byte(operand(1)));
  }

  void parallel() {
    switch (row_.format) {
      case Format::op3_store:
      case Format::op3_store_reversed: {
        const bool memory_first = row_.format == Format::op3_store;
        const bool exchanged = memory_first && of_three(0).kind == Kind::reg;
        const std::size_t memory = (memory_first && !exchanged) ? 0 : 1;
        if (operands().size() == 2 && memory == 1) need(3);
        put('a', low_register(of_three(2)));
        put('i', byte(operand(memory)));
        put('b', low_register(operand(1 - memory)));
        return store_half();
      }
      case Format::op2_store:
        need(2);
        put('i', byte(operand(0)));
        put('a', low_register(operand(1)));
        return store_half();
      case Format::load_load:
        need(2);
        put('i', byte(operand(0)));
        put('a', low_register(operand(1)));
        half_ = 1;
        need(2);
        put('j', byte(operand(0)));
        return put('b', low_register(operand(1)));
      case Format::store_store:
        need(2);
        put('a', low_register(operand(0)));
        put('i', byte(operand(1)));
        return store_half();
      default: return multiply_add();
    }
  }

  Word paired_destination(const OperandSyntax& o, unsigned lower) const {
    need_kind(o, Kind::reg, "a register");
    const unsigned number = isa::code(o.reg);
    if (number != lower && number != lower + 1)
      miss(Mismatch::contents, o.offset,
           fmt::format("{} goes to R{} or R{} here", lower == 0 ? "the product" : "the sum or difference", lower,
                       lower + 1));
    return number - lower;
  }

  /// Puts the operand into the memory field if it is indirect, else into the register field.
  void source_of_pair(const OperandSyntax& o, char field) {
    put(field, field == 'i' || field == 'j' ? byte(o) : low_register(o));
  }

  /// The fields of the operands in the order of the text, by P: product, then sum or difference (c40-isa.md 3.6).
  void multiply_add() {
    static constexpr std::array<std::string_view, 4> fields{"ijhx", "jxhi", "hxij", "jxih"};
    const std::string_view order = fields[row_.selector];
    const bool memory_then_register = order[0] == 'j' && order[1] == 'x';
    const bool exchanged = memory_then_register && of_three(0).kind == Kind::reg;
    source_of_pair(of_three(exchanged ? 1 : 0), order[0]);
    source_of_pair(of_three(exchanged ? 0 : 1), order[1]);
    put('p', paired_destination(of_three(2), 0));
    half_ = 1;
    source_of_pair(of_three(0), order[2]);
    source_of_pair(of_three(1), order[3]);
    put('q', paired_destination(of_three(2), 2));
  }

  Word word_;
};

/// LDP has no row of its own. TI's assembler encodes LDPK of the address's page or, with an address register, LDIU. GNU
/// as encodes LDIU to DP and takes a number as the page itself. For the C3x both encode LDIU.
Word encode_ldp(const HalfSyntax& half, const EncodeContext& context) {
  constexpr Word ldpk_word = 0x1F700000, ldiu_immediate = 0x50600000;
  const std::size_t count = half.operands.size();
  const bool names_register = count == 2 && half.operands[1].kind == Kind::reg;
  const isa::Register reg = names_register ? half.operands[1].reg : isa::Register::DP;
  const bool to_address_register = reg >= isa::Register::AR0 && reg <= isa::Register::AR7;
  const bool is_ti = context.dialect == Dialect::ti, is_c3x = context.cpu == isa::Cpu::c3x;
  // A game of 1994 has LDP x,R6. The source does not tell whether TI's assembler encoded a load of R6 or of DP.
  if (names_register && is_ti && reg != isa::Register::DP && !to_address_register)
    throw LineError{half.operands[1].offset,
                    fmt::format("'ldp' loads DP or AR0 to AR7, not {0}, and TI's encoding for {0} is not known; "
                                "'ldp x' loads DP, 'ldiu hi16(x),{0}' loads {0}",
                                isa::name(reg))};
  if (count == 0 || count > 2 || (count == 2 && !names_register) ||
      (reg != isa::Register::DP && !(to_address_register && is_ti)))
    throw LineError{
        half.offset,
        is_ti ? "'ldp' takes an address, and DP, AR0 to AR7 or nothing after it"
              : "'ldp' takes an address or a page, and DP or nothing after it (AR0 to AR7 with --dialect ti)"};
  const Word ldiu = ldiu_immediate | Word{isa::code(reg)} << 16;
  const Candidate ldpk = candidates("ldpk", isa::Cpu::c40).front();
  try {
    const OperandEncoder encoder(ldpk, half, nullptr, context);
    const OperandSyntax& place = half.operands[0];
    const Word word = (is_ti && !is_c3x && !to_address_register ? ldpk_word : ldiu) |
                      (is_ti ? encoder.page_of_address(place) : encoder.page(place));
    encoder.note_relocations();
    return word;
  } catch (const Mismatch& mismatch) {
    throw mismatch.error;
  }
}

[[noreturn]] void refuse_unknown_name(const HalfSyntax& half, std::string_view what, isa::Cpu cpu, int number) {
  const std::string foreign = mnemonic_of_other(half.mnemonic, cpu);
  if (!foreign.empty()) throw LineError{half.offset, foreign, number};
  throw LineError{half.offset, fmt::format("there is no {} '{}'{}", what, half.written, suggestion(half.mnemonic, cpu)),
                  number};
}

[[noreturn]] void refuse_unknown(const HalfSyntax& first, const HalfSyntax* second, isa::Cpu cpu) {
  if (candidates(first.mnemonic, cpu).empty() && !is_parallel_name(first.mnemonic, cpu))
    refuse_unknown_name(first, "instruction, directive or macro", cpu, 0);
  if (second == nullptr)
    throw LineError{first.offset, fmt::format("'{}' is half of a parallel instruction only", first.mnemonic)};
  if (candidates(second->mnemonic, cpu).empty() && !is_parallel_name(second->mnemonic, cpu))
    refuse_unknown_name(*second, "instruction", cpu, 1);
  throw LineError{second->offset, fmt::format("'{}' and '{}' cannot run in parallel", first.mnemonic, second->mnemonic),
                  1};
}

const std::vector<Candidate>& tries(const HalfSyntax& first, const HalfSyntax* second, isa::Cpu cpu) {
  return second != nullptr ? pair_candidates(first.mnemonic, second->mnemonic, cpu) : candidates(first.mnemonic, cpu);
}

/// Whether the other processor has an instruction with these operands.
bool other_takes(const HalfSyntax& first, const HalfSyntax* second, const EncodeContext& context) {
  std::vector<FieldRelocation> relocations;
  const std::function<void(const LineError&)> no_warning = [](const LineError&) {};
  const isa::Cpu other = other_than(context.cpu);
  const EncodeContext there{
      context.pc,      context.symbols, no_warning, context.relocations != nullptr ? &relocations : nullptr,
      context.section, context.dialect, other};
  for (const Candidate& candidate : tries(first, second, other)) {
    try {
      Attempt(candidate, first, second, there).encode();
      return true;
    } catch (const Mismatch&) {
      continue;
    }
  }
  return false;
}

}  // namespace

bool is_mnemonic(std::string_view name, isa::Cpu cpu) {
  return name == "ldp" || !candidates(name, cpu).empty() || is_parallel_name(name, cpu);
}

Word encode(const HalfSyntax& first, const HalfSyntax* second, const EncodeContext& context) {
  if (first.mnemonic == "ldp" && second == nullptr) return encode_ldp(first, context);
  const auto& rows = tries(first, second, context.cpu);
  if (rows.empty()) refuse_unknown(first, second, context.cpu);
  std::optional<Mismatch> nearest;
  for (const Candidate& candidate : rows) {
    try {
      return Attempt(candidate, first, second, context).encode();
    } catch (Mismatch& mismatch) {
      if (!nearest || mismatch.rank > nearest->rank) nearest = std::move(mismatch);
    }
  }
  if (other_takes(first, second, context))
    nearest->error.message +=
        fmt::format("; only the {} has '{}' with these operands", isa::title(other_than(context.cpu)), first.written);
  throw nearest->error;
}

}  // namespace toolchain
