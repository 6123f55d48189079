#include "toolchain/encoder.hpp"

#include <fmt/format.h>

#include <map>
#include <utility>

#include "isa/table.hpp"
#include "toolchain/mnemonics.hpp"

namespace toolchain {
namespace {

using isa::Format;
using isa::Immediate;
using isa::OperandClass;
using isa::Row;
using isa::Word;
using Kind = OperandSyntax::Kind;

constexpr Word no_byte = ~Word{0};

/// A row that does not fit; the nearest miss of all candidates is what the user is told.
struct Mismatch {
  enum Rank { count, kind, contents } rank;
  LineError error;
};

std::string kind_text(const OperandSyntax& operand) {
  switch (operand.kind) {
    case Kind::reg: return fmt::format("the register {}", isa::name(operand.reg));
    case Kind::expansion: return fmt::format("the expansion register {}", isa::name(operand.expansion));
    case Kind::direct: return "a direct address";
    case Kind::indirect: return "an indirect address";
    case Kind::expression: return "a number or label";
  }
  return {};
}

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

bool fits_signed(std::int64_t value, unsigned bits) {
  return value >= -(std::int64_t{1} << (bits - 1)) && value < (std::int64_t{1} << (bits - 1));
}
bool fits_unsigned(std::int64_t value, unsigned bits) { return value >= 0 && value < (std::int64_t{1} << bits); }

/// One try to fit a statement into one row.
class Attempt {
 public:
  Attempt(const Candidate& candidate, const HalfSyntax& first, const HalfSyntax* second, const EncodeContext& context)
      : row_(*candidate.row), swapped_(candidate.exchanged), context_(context), word_(row_.bits.match) {
    halves_[0] = candidate.exchanged ? second : &first;
    halves_[1] = candidate.exchanged ? &first : second;
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
    return word_;
  }

 private:
  [[noreturn]] void miss(Mismatch::Rank rank, std::size_t offset, std::string message) const {
    throw Mismatch{rank, LineError{offset, std::move(message), swapped_ ? 1 - half_ : half_}};
  }

  void put(char field, Word value) { word_ |= row_.bits.field(field).put(value); }

  const std::vector<OperandSyntax>& operands() const { return halves_[half_]->operands; }
  const OperandSyntax& operand(std::size_t i) const { return operands()[i]; }

  void need(std::size_t count) const {
    if (operands().size() == count) return;
    const auto& mnemonic = halves_[half_]->mnemonic;
    miss(Mismatch::count, operands().size() > count ? operand(count).offset : halves_[half_]->offset,
         count == 0 ? fmt::format("'{}' takes no operand", mnemonic)
                    : fmt::format("'{}' takes {} operand{}, not {}", mnemonic, count, count == 1 ? "" : "s",
                                  operands().size()));
  }

  // Values

  Value value(const OperandSyntax& o) const { return toolchain::evaluate(*o.expression, context_.symbols); }

  std::int64_t integer(const OperandSyntax& o, Value v) const {
    if (v.is_real()) miss(Mismatch::contents, o.offset, "an integer is needed here, not a float");
    return v.is_absolute() ? v.integer : context_.symbols.address_of_section(v.section) + v.integer;
  }
  std::int64_t integer(const OperandSyntax& o) const { return integer(o, value(o)); }

  Word in_range(const OperandSyntax& o, std::int64_t number, bool fits, std::string_view range) const {
    if (!fits) miss(Mismatch::contents, o.offset, fmt::format("{} is out of range ({})", number, range));
    return static_cast<Word>(number);
  }

  void need_kind(const OperandSyntax& o, Kind kind, std::string_view wanted) const {
    if (o.kind != kind) miss(Mismatch::kind, o.offset, fmt::format("{} is needed here, not {}", wanted, kind_text(o)));
  }

  // Registers

  Word register_code(const OperandSyntax& o, OperandClass allowed) const {
    need_kind(o, Kind::reg, "a register");
    if (allowed == OperandClass::floating && !isa::is_extended(o.reg))
      miss(Mismatch::contents, o.offset, fmt::format("{} holds no float; only R0 to R11 do", isa::name(o.reg)));
    if (allowed == OperandClass::lda && !isa::is_lda_destination(o.reg))
      miss(Mismatch::contents, o.offset,
           fmt::format("LDA loads AR0-AR7, DP, IR0, IR1, BK and SP, not {}", isa::name(o.reg)));
    return isa::code(o.reg);
  }

  Word low_register(const OperandSyntax& o) const {
    need_kind(o, Kind::reg, "a register");
    if (isa::code(o.reg) > 7)
      miss(Mismatch::contents, o.offset, fmt::format("parallel instructions reach R0 to R7 only, not {}", isa::name(o.reg)));
    return isa::code(o.reg);
  }

  Word expansion_code(const OperandSyntax& o) const {
    need_kind(o, Kind::expansion, "IVTP or TVTP");
    return static_cast<Word>(o.expansion);
  }

  // Operands by addressing mode

  std::int64_t displacement(const OperandSyntax& o) const { return o.expression ? integer(o) : 1; }

  Word indirect_field(const OperandSyntax& o) const {
    Word m = o.modn, d = 0;
    if (m < 8) {
      const std::int64_t number = displacement(o);
      d = in_range(o, number, fits_unsigned(number, 8), "a displacement is 0 to 255");
      if (m == 0 && d == 0 && !o.exact) m = isa::modn::plain;
    }
    return m << 11 | (Word{isa::code(o.reg)} & 7) << 8 | d;
  }

  /// The 8-bit form, where a displacement can only be 1; no_byte if it is another.
  Word try_byte(const OperandSyntax& o) const {
    Word m = o.modn;
    if (m < 8) {
      const std::int64_t d = displacement(o);
      if (o.exact) return no_byte;
      if (m == 0 && d == 0) m = isa::modn::plain;
      else if (d != 1) return no_byte;
    }
    return m << 3 | (Word{isa::code(o.reg)} & 7);
  }

  Word byte(const OperandSyntax& o) const {
    need_kind(o, Kind::indirect, "an indirect address");
    const Word bits = try_byte(o);
    if (bits == no_byte) miss(Mismatch::contents, o.offset, "the displacement can only be 1 in this instruction");
    return bits;
  }

  Word immediate(const OperandSyntax& o) const {
    const Value v = value(o);
    if (o.exact) return in_range(o, integer(o, v), fits_unsigned(integer(o, v), 16), "=x is a field of 16 bits");
    if (row_.immediate == Immediate::short_float) return short_float(o, v);
    const std::int64_t number = integer(o, v);
    if (!v.is_absolute() && !fits_signed(number, 16))
      miss(Mismatch::contents, o.offset,
           "an address has 32 bits; load it with LDHI hi16(x),reg and OR lo16(x),reg, or from a .word");
    // GNU as takes these two as signed, the chip zero-extends them (c40-isa.md 10.15): the bits are the same.
    const bool sign_too = row_.operation == isa::Operation::subc || row_.operation == isa::Operation::mpyuhi;
    if (row_.immediate == Immediate::zero)
      return in_range(o, number, fits_unsigned(number, 16) || (sign_too && fits_signed(number, 16)), "0 to 65535");
    if (!fits_signed(number, 16) && fits_unsigned(number, 16))
      context_.on_warning({o.offset, fmt::format("{} is taken as the signed number {}", number, number - 65536), half_});
    return in_range(o, number, fits_signed(number, 16) || fits_unsigned(number, 16), "-32768 to 32767");
  }

  Word short_float(const OperandSyntax& o, const Value& v) const {
    const Real real = v.is_real() ? v.real : Real(static_cast<double>(integer(o, v)));
    const auto bits = to_short(real);
    if (!bits) miss(Mismatch::contents, o.offset, "out of the range of a 16-bit float (-256 to 255.9375)");
    return row_.operation == isa::Operation::ldm ? *bits & 0xFFF : *bits;
  }

  /// The operand that G selects.
  void general(const OperandSyntax& o) {
    const unsigned mode = o.kind == Kind::reg        ? 0
                          : o.kind == Kind::direct   ? 1
                          : o.kind == Kind::indirect ? 2
                                                     : 3;
    if ((row_.modes >> mode & 1) == 0 || o.kind == Kind::expansion)
      miss(Mismatch::kind, o.offset, fmt::format("{} is needed here, not {}", modes_text(row_.modes), kind_text(o)));
    put('g', mode);
    put('s', mode == 0   ? register_code(o, row_.source)
             : mode == 1 ? static_cast<Word>(integer(o)) & 0xFFFF
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
      case Format::source:
        need(1);
        return general(operand(0));
      case Format::store:
        need(2);
        put('d', register_code(operand(0), row_.source));
        return general(operand(1));
      case Format::store_constant: return store_constant();
      case Format::register_source:
        need(1);
        return put('d', register_code(operand(0), row_.source));
      case Format::register_destination:
      case Format::register_both:
        need(1);
        return put('d', register_code(operand(0), row_.destination));
      case Format::load_constant:
        need(2);
        need_kind(operand(0), Kind::expression, "a number");
        put('k', immediate(operand(0)));
        return put('d', register_code(operand(1), row_.destination));
      case Format::load_page:
        need(1);
        return put('k', page(operand(0)));
      case Format::three_type1:
      case Format::three_type2: return three();
      case Format::branch_displacement:
      case Format::branch_register:
        need(1);
        return target(operand(0));
      case Format::decrement_displacement:
      case Format::decrement_register: return decrement();
      case Format::trap: {
        need(1);
        need_kind(operand(0), Kind::expression, "a trap number");
        const std::int64_t number = integer(operand(0));
        return put('k', in_range(operand(0), number, fits_unsigned(number, 9), "a trap number is 0 to 511"));
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

  /// Loads of a register from itself are no use, so they have no short form.
  bool is_load() const {
    using enum isa::Operation;
    const auto op = row_.operation;
    return op == ldi || op == ldf || op == ldi_cond || op == ldf_cond || op == lda || op == lb || op == lbu || op == lh || op == lhu;
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
    put('s', is_direct ? static_cast<Word>(integer(operand(1))) & 0xFFFF : indirect_field(operand(1)));
  }

 public:
  /// A page number, or the page of an address: @x always is an address, a label too, a number is the page itself.
  Word page(const OperandSyntax& o) const {
    if (o.kind == Kind::direct) return static_cast<Word>(integer(o)) >> 16;
    need_kind(o, Kind::expression, "a page number or @address");
    const Value v = value(o);
    const std::int64_t number = integer(o, v);
    if (!v.is_absolute()) return static_cast<Word>(number) >> 16;
    return in_range(o, number, fits_unsigned(number, 16), "a page is 0 to 65535; @x takes the page of the address x");
  }

 private:
  void target(const OperandSyntax& o) {
    if (row_.format == Format::branch_register || row_.format == Format::decrement_register)
      return put('r', register_code(o, row_.source));
    need_kind(o, Kind::expression, "a label or a register");
    const auto origin = static_cast<Word>(context_.pc + row_.selector);
    const auto distance = static_cast<std::int32_t>(static_cast<Word>(integer(o)) - origin);
    const unsigned width = row_.bits.field('v').width;
    if (!fits_signed(distance, width))
      miss(Mismatch::contents, o.offset,
           fmt::format("the target is {} words away; this branch reaches {} bits", distance, width));
    put('v', static_cast<Word>(distance));
  }

  void decrement() {
    need(2);
    need_kind(operand(0), Kind::reg, "AR0 to AR7");
    const unsigned counter = isa::code(operand(0).reg);
    if (counter < 8 || counter > 15)
      miss(Mismatch::contents, operand(0).offset, fmt::format("DBcond counts in AR0 to AR7, not in {}", isa::name(operand(0).reg)));
    put('n', counter & 7);
    target(operand(1));
  }

  /// src2, src1[, dst]; with dst left out, src1 is the destination too.
  void three() {
    const bool writes = row_.has('d');
    if (!(writes && operands().size() == 2)) need(writes ? 3 : 2);
    if (writes) put('d', register_code(operands().back(), row_.destination));
    const OperandSyntax &src2 = operand(0), &src1 = operand(1);
    if (row_.format == Format::three_type1) return type1(src1, src2);
    if (row_.commutative && !fits_type2(src1, src2) && fits_type2(src2, src1)) return type2(src2, src1);
    type2(src1, src2);
  }

  Word type1_byte(const OperandSyntax& o) const {
    return o.kind == Kind::indirect ? byte(o) : register_code(o, row_.source);
  }

  void type1(const OperandSyntax& src1, const OperandSyntax& src2) {
    put('t', (src1.kind == Kind::indirect ? 1U : 0U) | (src2.kind == Kind::indirect ? 2U : 0U));
    put('i', type1_byte(src2));
    put('j', type1_byte(src1));
  }

  bool is_type2_indirect(const OperandSyntax& o) const {
    return o.kind == Kind::indirect && (o.modn == isa::modn::plain || (o.modn == 0 && fits_unsigned(displacement(o), 5)));
  }

  bool fits_type2(const OperandSyntax& src1, const OperandSyntax& src2) const {
    const bool second = is_type2_indirect(src2) || (src2.kind == Kind::expression && row_.immediate != Immediate::none);
    return second && (src1.kind == Kind::reg || is_type2_indirect(src1));
  }

  Word type2_byte(const OperandSyntax& o) const {
    if (!is_type2_indirect(o))
      miss(o.kind == Kind::indirect ? Mismatch::contents : Mismatch::kind, o.offset,
           o.kind == Kind::indirect
               ? "a three-operand instruction takes *+ARn(0..31), or any indirect form with a displacement of 1"
               : fmt::format("no encoding takes {} here; an immediate or *+ARn(x) can be the first operand only{}", kind_text(o),
                             row_.immediate == Immediate::none ? ", and float instructions take no immediate" : ""));
    const Word d = o.modn == isa::modn::plain ? 0 : static_cast<Word>(displacement(o));
    return d << 3 | (Word{isa::code(o.reg)} & 7);
  }

  void type2(const OperandSyntax& src1, const OperandSyntax& src2) {
    const bool constant = src2.kind == Kind::expression;
    put('t', (src1.kind == Kind::indirect ? 2U : 0U) | (constant ? 0U : 1U));
    put('j', src1.kind == Kind::indirect ? type2_byte(src1) : register_code(src1, row_.source));
    if (!constant) return put('i', type2_byte(src2));
    if (row_.immediate == Immediate::none)
      miss(Mismatch::kind, src2.offset, "float instructions with three operands take no immediate");
    const std::int64_t number = integer(src2);
    put('i', in_range(src2, number, fits_signed(number, 8), "an immediate of three-operand instructions is -128 to 127") & 255);
  }

  // Parallel formats

  /// Operand i of the half at hand; with the destination left out, the last source is the destination too.
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
           fmt::format("{} goes to R{} or R{} here", lower == 0 ? "the product" : "the sum or difference", lower, lower + 1));
    return number - lower;
  }

  /// Puts the operand into the memory field if it is indirect, else into the register field.
  void source_of_pair(const OperandSyntax& o, char field) {
    put(field, field == 'i' || field == 'j' ? byte(o) : low_register(o));
  }

  /// Fields of the operands in the order written, by P: product, then sum or difference (c40-isa.md 3.6).
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

  const Row& row_;
  bool swapped_;
  const EncodeContext& context_;
  Word word_;
  std::array<const HalfSyntax*, 2> halves_{};
  int half_ = 0;
};

/// LDP x[,DP] is LDIU page,DP: it has no row of its own (c40-isa.md 3.8).
Word encode_ldp(const HalfSyntax& half, const EncodeContext& context) {
  const std::size_t count = half.operands.size();
  const bool names_dp = count == 2 && half.operands[1].kind == Kind::reg && half.operands[1].reg == isa::Register::DP;
  if (count != 1 && !names_dp) throw LineError{half.offset, "'ldp' takes an address or a page, and DP or nothing after it"};
  constexpr Word ldiu_immediate_dp = 0x50700000;
  const Candidate ldpk = candidates("ldpk").front();
  try {
    return ldiu_immediate_dp | Attempt(ldpk, half, nullptr, context).page(half.operands[0]);
  } catch (const Mismatch& mismatch) {
    throw mismatch.error;
  }
}

[[noreturn]] void refuse_unknown(const HalfSyntax& first, const HalfSyntax* second) {
  if (candidates(first.mnemonic).empty() && !is_parallel_name(first.mnemonic))
    throw LineError{first.offset, fmt::format("no instruction, directive or macro is called '{}'{}", first.mnemonic,
                                              suggestion(first.mnemonic))};
  if (second == nullptr)
    throw LineError{first.offset, fmt::format("'{}' is half of a parallel instruction only", first.mnemonic)};
  if (candidates(second->mnemonic).empty() && !is_parallel_name(second->mnemonic))
    throw LineError{second->offset, fmt::format("no instruction is called '{}'{}", second->mnemonic, suggestion(second->mnemonic)), 1};
  throw LineError{second->offset, fmt::format("'{}' and '{}' cannot run in parallel", first.mnemonic, second->mnemonic), 1};
}

}  // namespace

bool is_mnemonic(std::string_view name) {
  return name == "ldp" || !candidates(name).empty() || is_parallel_name(name);
}

Word encode(const HalfSyntax& first, const HalfSyntax* second, const EncodeContext& context) {
  if (first.mnemonic == "ldp" && second == nullptr) return encode_ldp(first, context);
  const auto& tries = second != nullptr ? pair_candidates(first.mnemonic, second->mnemonic) : candidates(first.mnemonic);
  if (tries.empty()) refuse_unknown(first, second);
  std::optional<Mismatch> nearest;
  for (const Candidate& candidate : tries) {
    try {
      return Attempt(candidate, first, second, context).encode();
    } catch (Mismatch& mismatch) {
      if (!nearest || mismatch.rank > nearest->rank) nearest = std::move(mismatch);
    }
  }
  throw nearest->error;
}

}  // namespace toolchain
