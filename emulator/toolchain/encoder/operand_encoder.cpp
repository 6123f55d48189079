#include "toolchain/encoder/operand_encoder.hpp"

#include <fmt/format.h>

#include "isa/ascii.hpp"

namespace toolchain {

using isa::Immediate;
using isa::OperandClass;
using isa::Word;
using Kind = OperandSyntax::Kind;

namespace {

/// The chip extends these immediates with zeros; GNU as takes them as signed (c40-isa.md 10.6, 10.15). The bits are the
/// same.
bool gnu_takes_signed(isa::Operation operation) {
  using enum isa::Operation;
  return operation == subc || operation == mpyuhi || operation == lwl || operation == lwr || operation == mb ||
         operation == mh;
}

}  // namespace

std::string kind_text(const OperandSyntax& operand, isa::Cpu cpu) {
  switch (operand.kind) {
    case Kind::reg: return fmt::format("the register {}", isa::name(operand.reg, cpu));
    case Kind::expansion: return fmt::format("the expansion register {}", isa::name(operand.expansion));
    case Kind::direct: return "a direct address";
    case Kind::indirect: return "an indirect address";
    case Kind::expression: return "a number or label";
  }
  return {};
}

bool is_logical(isa::Operation operation) {
  using enum isa::Operation;
  return operation == and_ || operation == andn || operation == or_ || operation == tstb || operation == xor_;
}

Value::Half half_taken_by(isa::Operation operation) {
  if (operation == isa::Operation::ldhi || operation == isa::Operation::ldpk) return Value::Half::high;
  return is_logical(operation) ? Value::Half::low : Value::Half::none;
}

bool fits_signed(std::int64_t value, unsigned bits) {
  return value >= -(std::int64_t{1} << (bits - 1)) && value < (std::int64_t{1} << (bits - 1));
}

bool fits_unsigned(std::int64_t value, unsigned bits) { return value >= 0 && value < (std::int64_t{1} << bits); }

bool immediate_takes(const isa::Row& row, std::int64_t number, bool is_address) {
  const bool from_zero = row.immediate == Immediate::zero;
  if (from_zero ? fits_unsigned(number, 16) : fits_signed(number, 16)) return true;
  if (is_address) return false;
  return from_zero ? gnu_takes_signed(row.operation) && fits_signed(number, 16) : fits_unsigned(number, 16);
}

OperandEncoder::OperandEncoder(const Candidate& candidate, const HalfSyntax& first, const HalfSyntax* second,
                               const EncodeContext& context)
    : row_(*candidate.row), context_(context), exchanged_(candidate.exchanged) {
  halves_ = {&first, second};
  if (exchanged_) halves_ = {second, &first};
}

void OperandEncoder::note_relocations() const {
  if (context_.relocations != nullptr)
    context_.relocations->insert(context_.relocations->end(), relocations_.begin(), relocations_.end());
}

void OperandEncoder::miss(Mismatch::Rank rank, std::size_t offset, std::string message) const {
  throw Mismatch{rank, LineError{offset, std::move(message), exchanged_ ? 1 - half_ : half_}};
}

void OperandEncoder::need(std::size_t count) const {
  const std::size_t given = operands().size();
  if (given == count) return;
  const std::size_t offset = given > count ? operand(count).offset : half().offset;
  if (count == 0) miss(Mismatch::count, offset, fmt::format("'{}' takes no operand", half().mnemonic));
  miss(Mismatch::count, offset,
       fmt::format("'{}' takes {} operand{}, not {}", half().mnemonic, count, count == 1 ? "" : "s", given));
}

void OperandEncoder::need_kind(const OperandSyntax& o, Kind kind, std::string_view wanted) const {
  if (o.kind == kind) return;
  const bool named = kind == Kind::reg && o.kind == Kind::expression && o.expression->kind == Expression::Kind::symbol;
  miss(Mismatch::kind, o.offset,
       fmt::format("{} is needed here, not {}{}", wanted, kind_text(o, context_.cpu),
                   named ? register_of_other(o.expression->name, context_.cpu) : ""));
}

// Values

Value OperandEncoder::value(const OperandSyntax& o) const { return evaluate(*o.expression, context_.symbols); }

std::int64_t OperandEncoder::integer(const OperandSyntax& o, const Value& v) const {
  if (v.is_real()) miss(Mismatch::contents, o.offset, "an integer is needed here, not a float");
  if (v.is_absolute()) return v.integer;
  if (context_.relocations != nullptr)
    miss(Mismatch::contents, o.offset, "an address that the linker assigns is not possible here");
  return context_.symbols.number_of(v);
}

std::int64_t OperandEncoder::address(const OperandSyntax& o, const Value& v, RelocationType type) const {
  if (context_.relocations == nullptr || v.is_real()) return integer(o, v);
  const bool settled = is_relative(type) ? v.section == context_.section : v.is_absolute();
  if (!settled) relocations_.push_back({type, v});
  const unsigned bits = width(type);
  const bool is_half = type == RelocationType::partls16 || type == RelocationType::partms16;
  if (v.half != Value::Half::none && !is_half)
    miss(Mismatch::contents, o.offset, "half of an address that the linker assigns is not possible here");
  const bool counts = v.is_external() ? !is_half : type == RelocationType::rel24 && !settled;
  if (counts && !fits_signed(v.integer, bits) && !(type == RelocationType::rel24 && fits_unsigned(v.integer, bits)))
    miss(Mismatch::contents, o.offset,
         fmt::format("{} is added to {} here, and the object has {} bits for it", v.integer,
                     v.is_external() ? "another object's symbol" : "an address", bits));
  return v.integer;
}

Word OperandEncoder::half_of_address(const OperandSyntax& o, const Value& v, Value::Half otherwise) const {
  const Value::Half which = v.half != Value::Half::none ? v.half : otherwise;
  if (which == Value::Half::high) return static_cast<Word>(address(o, v, RelocationType::partms16)) >> 16;
  return static_cast<Word>(address(o, v, RelocationType::partls16)) & 0xFFFF;
}

void OperandEncoder::need_whole(const OperandSyntax& o, const Value& v) const {
  if (v.half != Value::Half::none)
    miss(Mismatch::contents, o.offset, "a whole address is needed here; 'ldpk' takes half of one");
}

Word OperandEncoder::in_range(const OperandSyntax& o, std::int64_t number, bool fits, std::string_view range) const {
  if (!fits) miss(Mismatch::contents, o.offset, fmt::format("{} is out of range ({})", number, range));
  return static_cast<Word>(number);
}

// Registers

/// TI's assembler takes the number of an expansion register for a register's number: a boot EPROM of the Hydra board
/// contains 15402001h, STI R0, where its source says `sti ivtp,*ar0++`.
bool OperandEncoder::is_register(const OperandSyntax& o) const {
  return o.kind == Kind::reg || (o.kind == Kind::expansion && context_.dialect == Dialect::ti);
}

Word OperandEncoder::register_code(const OperandSyntax& o, OperandClass allowed) const {
  if (o.kind == Kind::expansion && is_register(o)) {
    const auto number = static_cast<Word>(o.expansion);
    context_.on_warning(
        {o.offset,
         fmt::format("{0} is taken as R{1}, whose number it has, as TI's assembler takes it; LDEP and LDPE reach {0}",
                     isa::name(o.expansion), number),
         half_});
    return number;
  }
  need_kind(o, Kind::reg, "a register");
  if (allowed == OperandClass::floating && !isa::is_extended(o.reg))
    miss(Mismatch::contents, o.offset,
         fmt::format("{} cannot hold a float; only R0 to {} can", isa::name(o.reg, context_.cpu),
                     context_.cpu == isa::Cpu::c40 ? "R11" : "R7"));
  if (allowed == OperandClass::lda && !isa::is_lda_destination(o.reg))
    miss(Mismatch::contents, o.offset,
         fmt::format("LDA loads AR0-AR7, DP, IR0, IR1, BK and SP, not {}", isa::name(o.reg)));
  return isa::code(o.reg);
}

Word OperandEncoder::low_register(const OperandSyntax& o) const {
  need_kind(o, Kind::reg, "a register");
  if (isa::code(o.reg) > 7)
    miss(Mismatch::contents, o.offset,
         fmt::format("parallel instructions reach R0 to R7 only, not {}", isa::name(o.reg, context_.cpu)));
  return isa::code(o.reg);
}

Word OperandEncoder::expansion_code(const OperandSyntax& o) const {
  need_kind(o, Kind::expansion, "IVTP or TVTP");
  return static_cast<Word>(o.expansion);
}

// Addressing modes

std::int64_t OperandEncoder::displacement(const OperandSyntax& o) const { return o.expression ? integer(o) : 1; }

Word OperandEncoder::direct_field(const OperandSyntax& o) const {
  return half_of_address(o, value(o), Value::Half::low);
}

Word OperandEncoder::indirect_field(const OperandSyntax& o) const {
  Word m = o.modn, d = 0;
  if (m < 8) {
    const std::int64_t number = displacement(o);
    d = in_range(o, number, fits_unsigned(number, 8), "a displacement is 0 to 255");
    if (m == 0 && d == 0 && !o.exact) m = isa::modn::plain;
  }
  return m << 11 | (Word{isa::code(o.reg)} & 7) << 8 | d;
}

Word OperandEncoder::byte(const OperandSyntax& o, std::string_view refusal) const {
  need_kind(o, Kind::indirect, "an indirect address");
  Word m = o.modn;
  if (m < 8) {
    const std::int64_t d = displacement(o);
    if (m == 0 && d == 0 && !o.exact)
      m = isa::modn::plain;
    else if (d != 1 || o.exact)
      miss(Mismatch::contents, o.offset, std::string(refusal));
  }
  return m << 3 | (Word{isa::code(o.reg)} & 7);
}

Word OperandEncoder::immediate(const OperandSyntax& o) const {
  const Value v = value(o);
  if (o.exact) return in_range(o, integer(o, v), fits_unsigned(integer(o, v), 16), "=x is a field of 16 bits");
  if (row_.immediate == Immediate::short_float) {
    const Word bits = short_float(o, v);
    return row_.operation == isa::Operation::ldm ? bits & 0x0FFF : bits;  // the mantissa alone
  }
  const Value::Half taken = half_taken_by(row_.operation);
  if (v.half != Value::Half::none || (v.is_address() && !linker_decides(v) && taken != Value::Half::none))
    return half_of_address(o, v, taken);
  if (context_.relocations != nullptr && !v.is_absolute()) return number_or_address(o, v);
  const std::int64_t given = integer(o, v);
  const std::int64_t number = v.is_absolute() ? given : static_cast<std::int32_t>(static_cast<Word>(given));
  if (!v.is_absolute() && !immediate_takes(row_, number, true))
    miss(Mismatch::contents, o.offset,
         context_.cpu == isa::Cpu::c40
             ? "an address has 32 bits; load it with LDHI hi16(x),reg and OR lo16(x),reg, or from a .word"
             : "an address has 24 bits; load it from a .word, or with LDI hi16(x),reg, LSH 16,reg and OR lo16(x),reg");
  const bool fits = immediate_takes(row_, number, false);
  if (row_.immediate == Immediate::zero)
    return in_range(o, number, fits, gnu_takes_signed(row_.operation) ? "-32768 to 65535" : "0 to 65535");
  if (!fits_signed(number, 16) && fits)
    context_.on_warning({o.offset, fmt::format("{} is taken as the signed number {}", number, number - 65536), half_});
  return in_range(o, number, fits, "-32768 to 32767");
}

bool OperandEncoder::linker_decides(const Value& v) const {
  return v.is_external() && v.half == Value::Half::none && context_.dialect == Dialect::ti;
}

Word OperandEncoder::number_or_address(const OperandSyntax& o, const Value& v) const {
  return static_cast<Word>(address(o, v, RelocationType::relword)) & 0xFFFF;
}

Word OperandEncoder::short_float(const OperandSyntax& o, const Value& v) const {
  const Real real = v.is_real() ? v.real : real_of(integer(o, v));
  const auto bits = to_short(real);
  if (!bits) miss(Mismatch::contents, o.offset, "out of the range of a 16-bit float (-256 to 255.9375)");
  return *bits;
}

/// Only eight bits of the C3x's DP count.
Word OperandEncoder::page_that_exists(const OperandSyntax& o, std::int64_t page) const {
  const bool settled = context_.relocations == nullptr || value(o).is_absolute();
  if (context_.cpu == isa::Cpu::c40 || !settled) return static_cast<Word>(page) & 0xFFFF;
  return in_range(o, page, fits_unsigned(page, 8), "a page of the C3x is 0 to 255, that of an address up to 0FFFFFFh");
}

Word OperandEncoder::page(const OperandSyntax& o) const {
  if (o.kind != Kind::direct) need_kind(o, Kind::expression, "a page number or @address");
  const Value v = value(o);
  if (o.kind == Kind::direct) need_whole(o, v);
  if (o.kind != Kind::direct && linker_decides(v)) return number_or_address(o, v);
  if (o.kind == Kind::direct || v.is_address()) return page_that_exists(o, half_of_address(o, v, Value::Half::high));
  const std::int64_t number = integer(o, v);
  const Word page =
      in_range(o, number, fits_unsigned(number, 16), "a page is 0 to 65535; @x takes the page of the address x");
  return page_that_exists(o, page);
}

Word OperandEncoder::page_of_address(const OperandSyntax& o) const {
  if (o.kind != Kind::direct) need_kind(o, Kind::expression, "an address");
  const Value v = value(o);
  need_whole(o, v);
  const std::int64_t number = address(o, v, RelocationType::partms16);
  if (context_.relocations == nullptr || v.is_absolute())
    in_range(o, number, fits_unsigned(number, 32), "an address is 0 to 0FFFFFFFFh");
  const Word page = page_that_exists(o, static_cast<Word>(number) >> 16);
  if (o.kind == Kind::expression && v.is_absolute() && number > 0 && number <= 0xFFFF) {
    const bool named = operands().size() == 2;
    const std::string loads =
        named && operand(1).reg != isa::Register::DP
            ? fmt::format("'ldiu {0},{1}' loads {1} with {0:X}h", number, ascii::lower(isa::name(operand(1).reg)))
        : context_.cpu == isa::Cpu::c3x
            ? fmt::format("'ldiu {0},dp' loads page {0:X}h", number)
            : fmt::format("Earlier versions took it as page {0:X}h: use 'ldpk {0}', or --dialect gnu", number);
    context_.on_warning(
        {o.offset, fmt::format("'ldp' takes an address: {:X}h is in page 0. {}", number, loads), half_});
  }
  return page;
}

}  // namespace toolchain
