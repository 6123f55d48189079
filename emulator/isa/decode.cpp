#include "isa/decode.hpp"

#include <optional>
#include <vector>

namespace isa {
namespace {

using Kind = Operand::Kind;
using Reason = Reserved::Reason;

constexpr unsigned index_bits = 11;

/// The rows that words with given bits 31..21 can match. G and T are among these bits, so the modes are decided here
/// too.
class RowIndex {
 public:
  explicit RowIndex(Cpu cpu) {
    for (Word top = 0; top < (Word{1} << index_bits); ++top) {
      starts_.push_back(static_cast<std::uint16_t>(rows_.size()));
      const Word word = top << (32 - index_bits);
      const Word top_mask = ~Word{0} << (32 - index_bits);
      const Modes mode = static_cast<Modes>(1U << (top & 3));
      for (const Row& row : rows(cpu))
        if (((word ^ row.bits.match) & row.bits.mask & top_mask) == 0 && (row.modes & mode) != 0) rows_.push_back(&row);
    }
    starts_.push_back(static_cast<std::uint16_t>(rows_.size()));
  }

  const Row* find(Word word) const {
    const Word top = word >> (32 - index_bits);
    for (std::size_t i = starts_[top]; i < starts_[top + 1]; ++i)
      if ((word & rows_[i]->bits.mask) == rows_[i]->bits.match) return rows_[i];
    return nullptr;
  }

 private:
  std::vector<std::uint16_t> starts_;
  std::vector<const Row*> rows_;
};

const RowIndex& row_index(Cpu cpu) {
  static const RowIndex c40(Cpu::c40), c3x(Cpu::c3x);
  return cpu == Cpu::c40 ? c40 : c3x;
}

std::int32_t sign_extend(Word value, unsigned width) {
  const unsigned shift = 32 - width;
  return static_cast<std::int32_t>(value << shift) >> shift;
}

Operand value_operand(Kind kind, std::int32_t value) { return {.kind = kind, .value = value}; }

/// Reads the operands of one word and keeps the first violation of the row's rules.
class Reader {
 public:
  Reader(const Row& row, Word word, Cpu cpu) : row_(row), word_(word), cpu_(cpu) {}

  Word field(char letter) const { return row_.bits.field(letter).get(word_); }
  const std::optional<Reason>& offence() const { return offence_; }
  void offend(Reason reason) {
    if (!offence_) offence_ = reason;
  }

  Operand reg(Word code, OperandClass allowed) {
    const auto r = static_cast<Register>(code);
    if (!has(cpu_, r)) offend(Reason::register_class);
    if (allowed == OperandClass::floating && !is_extended(r)) offend(Reason::register_class);
    if (allowed == OperandClass::lda && !is_lda_destination(r)) offend(Reason::register_class);
    return {.kind = Kind::reg, .reg = r};
  }
  Operand source_register(char letter) { return reg(field(letter), row_.source); }
  Operand destination_register(char letter) { return reg(field(letter), row_.destination); }

  /// The operand that G (bits 22..21) selects from the 16-bit field.
  Operand general() { return general((word_ >> 21) & 3); }
  Operand general(Word mode) {
    const Word bits = field('s');
    switch (mode) {
      case 0:
        if ((bits >> 5) != 0) offend(Reason::reserved_bits);
        return reg(bits & 31, row_.source);
      case 1: return value_operand(Kind::direct, static_cast<std::int32_t>(bits));
      case 2: return indirect(bits >> 11, (bits >> 8) & 7, bits & 255, true, Slot::none);
      default: return immediate(bits, 16);
    }
  }

  Operand byte(char letter) {
    const Word bits = field(letter);
    return indirect(bits >> 3, bits & 7, 1, false, letter == 'j' ? Slot::j : Slot::i);
  }

  Operand type1(char letter, bool is_indirect) {
    if (is_indirect) return byte(letter);
    if ((field(letter) >> 5) != 0) offend(Reason::reserved_bits);
    return reg(field(letter) & 31, row_.source);
  }

  Operand type2_indirect(char letter) {
    const Word bits = field(letter);
    return {.kind = Kind::indirect,
            .reg = address_register(bits & 7),
            .modn = 0,
            .slot = letter == 'j' ? Slot::j : Slot::i,
            .value = static_cast<std::int32_t>(bits >> 3)};
  }

  Operand immediate(Word bits, unsigned width) const {
    if (row_.immediate == Immediate::short_float)
      return value_operand(Kind::immediate_float, static_cast<std::int32_t>(bits));
    return value_operand(Kind::immediate_int, row_.immediate == Immediate::sign ? sign_extend(bits, width)
                                                                                : static_cast<std::int32_t>(bits));
  }

  Operand target() const {
    const Field& displacement = row_.bits.field('v');
    return value_operand(Kind::target, sign_extend(displacement.get(word_), displacement.width) + row_.selector);
  }

  Operand expansion(Word code) {
    if (code > 1) offend(Reason::expansion_register);
    return value_operand(Kind::expansion, static_cast<std::int32_t>(code));
  }

 private:
  Operand indirect(Word m, Word arn, Word displacement, bool explicit_displacement, Slot slot) {
    if (!modn::is_legal(m)) offend(Reason::addressing_mode);
    const bool indexed = m >= 8;
    if (indexed && explicit_displacement && displacement != 0) offend(Reason::displacement);
    return {.kind = Kind::indirect,
            .reg = address_register(arn),
            .modn = static_cast<std::uint8_t>(m),
            .slot = slot,
            .value = indexed ? 0 : static_cast<std::int32_t>(displacement)};
  }

  const Row& row_;
  Word word_;
  Cpu cpu_;
  std::optional<Reason> offence_;
};

void read_three_type1(Reader& read, Instruction& out) {
  const Word t = read.field('t');
  out.src1 = read.type1('j', (t & 1) != 0);
  out.src2 = read.type1('i', (t & 2) != 0);
}

void read_three_type2(Reader& read, Instruction& out) {
  const Word t = read.field('t');
  out.src1 = (t & 2) != 0 ? read.type2_indirect('j') : read.type1('j', false);
  out.src2 = (t & 1) != 0 ? read.type2_indirect('i') : read.immediate(read.field('i'), 8);
}

/// The P field's four ways to assign J, I, K and H (c40-isa.md 3.6).
void read_multiply_add(Reader& read, Instruction& out) {
  const Operand i = read.byte('i'), j = read.byte('j');
  const Operand k = read.source_register('x'), h = read.source_register('h');
  switch (out.row->selector) {
    case 0: out.src1 = j, out.src2 = i, out.src3 = k, out.src4 = h; break;
    case 1: out.src1 = k, out.src2 = j, out.src3 = i, out.src4 = h; break;
    case 2: out.src1 = k, out.src2 = h, out.src3 = j, out.src4 = i; break;
    default: out.src1 = k, out.src2 = j, out.src3 = h, out.src4 = i; break;
  }
  out.dst = read.reg(read.field('p'), OperandClass::none);
  out.dst2 = read.reg(2 + read.field('q'), OperandClass::none);
}

void read_store_half(Reader& read, Instruction& out) {
  out.src3 = read.source_register('e');
  out.dst2 = read.byte('j');
}

void read_parallel(Reader& read, Instruction& out) {
  switch (out.row->format) {
    case Format::op3_store:
      out.dst = read.destination_register('a');
      out.src1 = read.source_register('b');
      out.src2 = read.byte('i');
      return read_store_half(read, out);
    case Format::op3_store_reversed:
      out.dst = read.destination_register('a');
      out.src1 = read.byte('i');
      out.src2 = read.source_register('b');
      return read_store_half(read, out);
    case Format::op2_store:
      out.dst = read.destination_register('a');
      out.src1 = read.byte('i');
      return read_store_half(read, out);
    case Format::load_load:
      out.dst = read.destination_register('a');
      out.src1 = read.byte('i');
      out.dst2 = read.destination_register('b');
      out.src3 = read.byte('j');
      return;
    case Format::store_store:
      out.src1 = read.source_register('a');
      out.dst = read.byte('i');
      return read_store_half(read, out);
    default: return read_multiply_add(read, out);
  }
}

void read_operands(Reader& read, Instruction& out) {
  const Row& row = *out.row;
  switch (row.format) {
    case Format::plain: return;
    case Format::unary:
      out.src1 = read.general();
      out.dst = read.destination_register('d');
      if (row.destination == OperandClass::lda && out.src1 == out.dst) read.offend(Reason::same_register);
      return;
    case Format::binary:
      out.src2 = read.general();
      out.src1 = out.dst = read.destination_register('d');
      return;
    case Format::binary_reversed:
      out.src1 = read.general();
      out.src2 = out.dst = read.destination_register('d');
      return;
    case Format::compare:
      out.src2 = read.general();
      out.src1 = read.source_register('d');
      return;
    case Format::source: out.src1 = read.general(); return;
    case Format::store:
      out.src1 = read.source_register('d');
      out.dst = read.general();
      return;
    case Format::store_constant:
      out.src1 = value_operand(Kind::immediate_int, sign_extend(read.field('k'), 5));
      out.dst = read.general(row.modes == 1 ? 1 : 2);
      return;
    case Format::register_source: out.src1 = read.source_register('d'); return;
    case Format::register_destination: out.dst = read.destination_register('d'); return;
    case Format::register_both: out.src1 = out.dst = read.destination_register('d'); return;
    case Format::load_constant:
      out.src1 = read.immediate(read.field('k'), 16);
      out.dst = read.destination_register('d');
      return;
    case Format::load_page:
      out.src1 = read.immediate(read.field('k'), 16);
      out.dst = {.kind = Kind::reg, .reg = Register::DP};
      return;
    case Format::three_type1:
    case Format::three_type2:
      row.format == Format::three_type1 ? read_three_type1(read, out) : read_three_type2(read, out);
      if (row.has('d')) out.dst = read.destination_register('d');
      return;
    case Format::branch_displacement: out.src1 = read.target(); return;
    case Format::branch_register: out.src1 = read.source_register('r'); return;
    case Format::branch_absolute:
      out.src1 = value_operand(Kind::address, static_cast<std::int32_t>(read.field('v')));
      return;
    case Format::decrement_displacement:
      out.src1 = read.target();
      out.dst = {.kind = Kind::reg, .reg = address_register(read.field('n'))};
      return;
    case Format::decrement_register:
      out.src1 = read.source_register('r');
      out.dst = {.kind = Kind::reg, .reg = address_register(read.field('n'))};
      return;
    case Format::trap: out.src1 = value_operand(Kind::trap, static_cast<std::int32_t>(read.field('k'))); return;
    case Format::from_expansion:
      out.src1 = read.expansion(read.field('r'));
      out.dst = read.destination_register('d');
      return;
    case Format::to_expansion:
      out.src1 = read.source_register('r');
      out.dst = read.expansion(read.field('d'));
      return;
    default: return read_parallel(read, out);
  }
}

}  // namespace

std::string_view describe(Reserved::Reason reason) {
  switch (reason) {
    case Reason::opcode: return "no instruction has this operation and addressing mode";
    case Reason::reserved_bits: return "bits that must be 0 are set";
    case Reason::register_class: return "this register is not possible in this place";
    case Reason::same_register: return "LDA cannot load a register from itself";
    case Reason::addressing_mode: return "indirect addressing modes 26 to 31 are reserved";
    case Reason::displacement: return "an index register leaves no place for a displacement";
    case Reason::condition: return "conditions 11 and 21 to 31 are reserved";
    case Reason::expansion_register: return "the expansion registers are IVTP and TVTP";
  }
  return "";
}

Decoded decode(Word word, Cpu cpu) {
  const Row* row = row_index(cpu).find(word);
  if (row == nullptr) return Reserved{Reason::opcode, word};
  Reader read(*row, word, cpu);
  Instruction out;
  out.row = row;
  out.word = word;
  if (row->conditional()) {
    const Word condition = read.field('c');
    if (!is_condition(condition)) return Reserved{Reason::condition, word};
    out.condition = static_cast<Condition>(condition);
  }
  read_operands(read, out);
  if (read.offence()) return Reserved{*read.offence(), word};
  return out;
}

bool is_program_control(const Instruction& instruction) {
  switch (instruction.row->operation) {
    case Operation::branch:
    case Operation::db:
    case Operation::call:
    case Operation::laj:
    case Operation::rets:
    case Operation::reti:
    case Operation::trap:
    case Operation::lat:
    case Operation::rptb:
    case Operation::rpts:
    case Operation::idle:
    case Operation::idle2: return true;
    default: return false;
  }
}

}  // namespace isa
