#include "isa/table.hpp"

#include <algorithm>

namespace isa {
namespace {

using O = Operation;
using F = Format;
using I = Immediate;
using X = FlagClass;
constexpr auto integer = OperandClass::integer;
constexpr auto floating = OperandClass::floating;
constexpr auto lda = OperandClass::lda;

// Bits 22..21 as a set of legal values: register, direct, indirect, immediate.
constexpr Modes reg = 1, direct = 2, indirect = 4, imm = 8;
constexpr Modes rdim = reg | direct | indirect | imm;
constexpr Modes di = direct | indirect;
// Float instructions have no 8-bit immediate, which type 2 puts at T = 0 and 2 (c40-isa.md 3.4).
constexpr Modes five_bit_only = 2 | 8;

// No document says how the immediates of these instructions are read (docs/fidelity.md).
constexpr I signed_part_immediate = I::sign;  // LB, LH
constexpr I other_part_immediate = I::zero;   // LBU, LHU, LWL, LWR, MB, MH
constexpr I mpyuhi_immediate = I::zero;
constexpr I subc_immediate = I::zero;

constexpr auto none = OperandClass::none;
constexpr Modes any = 15;

/// Members that only few rows set.
struct Extra {
  std::uint8_t cycles = 1;
  std::uint8_t selector = 0;
  Delay delay = Delay::none;
  WriteStage write_stage = WriteStage::execute;
  bool commutative = false;
  bool interlocked = false;
  bool c4x_only = false;
};

constexpr Row pair(std::string_view picture, std::string_view mnemonic, std::string_view mnemonic2, O operation,
                   O operation2, F format, OperandClass source, OperandClass destination, I immediate, Modes modes,
                   X flags, std::string_view section, Extra extra = {}) {
  return {picture,
          mnemonic,
          mnemonic2,
          operation,
          operation2,
          format,
          source,
          destination,
          immediate,
          modes,
          flags,
          extra.cycles,
          extra.selector,
          extra.delay,
          extra.write_stage,
          extra.commutative,
          extra.interlocked,
          extra.c4x_only,
          section,
          parse_picture(picture)};
}

constexpr Row row(std::string_view picture, std::string_view mnemonic, O operation, F format, OperandClass source,
                  OperandClass destination, I immediate, Modes modes, X flags, std::string_view section,
                  Extra extra = {}) {
  return pair(picture, mnemonic, "", operation, O::none, format, source, destination, immediate, modes, flags, section,
              extra);
}

// In compares of type 2 the field of the destination (letter z) has no meaning (docs/fidelity.md).
// clang-format off
constexpr std::array table{
    // General addressing, by bits 28..23.
    row("000 000000 gg ddddd ssssssssssssssss", "absf", O::absf, F::unary, floating, floating, I::short_float, rdim, X::F, "6.1"),
    row("000 000001 gg ddddd ssssssssssssssss", "absi", O::absi, F::unary, integer, integer, I::sign, rdim, X::B, "6.1"),
    row("000 000010 gg ddddd ssssssssssssssss", "addc", O::addc, F::binary, integer, integer, I::sign, rdim, X::A, "6.1"),
    row("000 000011 gg ddddd ssssssssssssssss", "addf", O::addf, F::binary, floating, floating, I::short_float, rdim, X::F, "6.1"),
    row("000 000100 gg ddddd ssssssssssssssss", "addi", O::addi, F::binary, integer, integer, I::sign, rdim, X::A, "6.1"),
    row("000 000101 gg ddddd ssssssssssssssss", "and", O::and_, F::binary, integer, integer, I::zero, rdim, X::L, "6.1"),
    row("000 000110 gg ddddd ssssssssssssssss", "andn", O::andn, F::binary, integer, integer, I::zero, rdim, X::L, "6.1"),
    row("000 000111 gg ddddd ssssssssssssssss", "ash", O::ash, F::binary, integer, integer, I::sign, rdim, X::SA, "6.1"),
    row("000 001000 gg ddddd ssssssssssssssss", "cmpf", O::cmpf, F::compare, floating, none, I::short_float, rdim, X::F, "6.1"),
    row("000 001001 gg ddddd ssssssssssssssss", "cmpi", O::cmpi, F::compare, integer, none, I::sign, rdim, X::A, "6.1"),
    row("000 001010 gg ddddd ssssssssssssssss", "fix", O::fix, F::unary, floating, integer, I::short_float, rdim, X::B, "6.1"),
    row("000 001011 gg ddddd ssssssssssssssss", "float", O::float_, F::unary, integer, floating, I::sign, rdim, X::G, "6.1"),
    row("000 001100 00 00000 0000000000000000", "idle", O::idle, F::plain, none, none, I::none, any, X::none, "6.6"),
    row("000 001100 00 00000 0000000000000001", "idle2", O::idle2, F::plain, none, none, I::none, any, X::none, "6.6", {.c4x_only = true}),
    row("000 001101 gg ddddd ssssssssssssssss", "lde", O::lde, F::binary_reversed, floating, floating, I::short_float, rdim, X::none, "6.1"),
    row("000 001110 gg ddddd ssssssssssssssss", "ldf", O::ldf, F::unary, floating, floating, I::short_float, rdim, X::G, "6.1"),
    row("000 001111 gg ddddd ssssssssssssssss", "ldfi", O::ldfi, F::unary, floating, floating, I::none, di, X::G, "6.7", {.interlocked = true}),
    row("000 010000 gg ddddd ssssssssssssssss", "ldi", O::ldi, F::unary, integer, integer, I::sign, rdim, X::L, "6.1"),
    row("000 010001 gg ddddd ssssssssssssssss", "ldii", O::ldii, F::unary, integer, integer, I::none, di, X::L, "6.7", {.interlocked = true}),
    row("000 010010 gg ddddd ssssssssssssssss", "ldm", O::ldm, F::binary_reversed, floating, floating, I::short_float, rdim, X::none, "6.1"),
    row("000 010011 gg ddddd ssssssssssssssss", "lsh", O::lsh, F::binary, integer, integer, I::sign, rdim, X::S, "6.1"),
    row("000 010100 gg ddddd ssssssssssssssss", "mpyf", O::mpyf, F::binary, floating, floating, I::short_float, rdim, X::F, "6.1"),
    row("000 010101 gg ddddd ssssssssssssssss", "mpyi", O::mpyi, F::binary, integer, integer, I::sign, rdim, X::B, "6.1"),
    row("000 010110 gg ddddd ssssssssssssssss", "negb", O::negb, F::unary, integer, integer, I::sign, rdim, X::A, "6.1"),
    row("000 010111 gg ddddd ssssssssssssssss", "negf", O::negf, F::unary, floating, floating, I::short_float, rdim, X::F, "6.1"),
    row("000 011000 gg ddddd ssssssssssssssss", "negi", O::negi, F::unary, integer, integer, I::sign, rdim, X::A, "6.1"),
    row("000 011001 00 00000 0000000000000000", "nop", O::nop, F::plain, none, none, I::none, any, X::none, "6.1"),
    row("000 011001 10 00000 ssssssssssssssss", "nop", O::nop, F::source, none, none, I::none, indirect, X::none, "6.1"),
    row("000 011010 gg ddddd ssssssssssssssss", "norm", O::norm, F::unary, floating, floating, I::short_float, rdim, X::normalize, "6.1"),
    row("000 011011 gg ddddd ssssssssssssssss", "not", O::not_, F::unary, integer, integer, I::zero, rdim, X::L, "6.1"),
    row("000 011100 01 ddddd 0000000000000000", "pop", O::pop, F::register_destination, none, integer, I::none, any, X::L, "6.1"),
    row("000 011101 01 ddddd 0000000000000000", "popf", O::popf, F::register_destination, none, floating, I::none, any, X::G, "6.1"),
    row("000 011110 01 ddddd 0000000000000000", "push", O::push, F::register_source, integer, none, I::none, any, X::none, "6.1"),
    row("000 011111 01 ddddd 0000000000000000", "pushf", O::pushf, F::register_source, floating, none, I::none, any, X::none, "6.1"),
    row("000 100000 gg ddddd ssssssssssssssss", "or", O::or_, F::binary, integer, integer, I::zero, rdim, X::L, "6.1"),
    row("000 100010 gg ddddd ssssssssssssssss", "rnd", O::rnd, F::unary, floating, floating, I::short_float, rdim, X::round, "6.1"),
    row("000 100011 11 ddddd 0000000000000001", "rol", O::rol, F::register_both, integer, integer, I::none, any, X::S, "6.1"),
    row("000 100100 11 ddddd 0000000000000001", "rolc", O::rolc, F::register_both, integer, integer, I::none, any, X::S, "6.1"),
    row("000 100101 11 ddddd 1111111111111111", "ror", O::ror, F::register_both, integer, integer, I::none, any, X::S, "6.1"),
    row("000 100110 11 ddddd 1111111111111111", "rorc", O::rorc, F::register_both, integer, integer, I::none, any, X::S, "6.1"),
    row("000 100111 gg 11011 ssssssssssssssss", "rpts", O::rpts, F::source, integer, none, I::zero, rdim, X::none, "8.4", {.cycles = 4}),
    row("000 101000 gg ddddd ssssssssssssssss", "stf", O::stf, F::store, floating, none, I::none, di, X::none, "6.1"),
    row("000 101001 gg ddddd ssssssssssssssss", "stfi", O::stfi, F::store, floating, none, I::none, di, X::none, "6.7", {.interlocked = true}),
    row("000 101010 gg ddddd ssssssssssssssss", "sti", O::sti, F::store, integer, none, I::none, di, X::none, "6.1"),
    row("000 101010 00 kkkkk ssssssssssssssss", "stik", O::sti, F::store_constant, none, none, I::none, reg, X::none, "6.1", {.c4x_only = true}),
    row("000 101010 11 kkkkk ssssssssssssssss", "stik", O::sti, F::store_constant, none, none, I::none, imm, X::none, "6.1", {.c4x_only = true}),
    row("000 101011 gg ddddd ssssssssssssssss", "stii", O::stii, F::store, integer, none, I::none, di, X::none, "6.7", {.interlocked = true}),
    row("000 101100 gg ddddd ssssssssssssssss", "sigi", O::sigi, F::unary, integer, integer, I::none, di, X::L, "6.7", {.interlocked = true, .c4x_only = true}),
    row("000 101101 gg ddddd ssssssssssssssss", "subb", O::subb, F::binary, integer, integer, I::sign, rdim, X::A, "6.1"),
    row("000 101110 gg ddddd ssssssssssssssss", "subc", O::subc, F::binary, integer, integer, subc_immediate, rdim, X::none, "7.9"),
    row("000 101111 gg ddddd ssssssssssssssss", "subf", O::subf, F::binary, floating, floating, I::short_float, rdim, X::F, "6.1"),
    row("000 110000 gg ddddd ssssssssssssssss", "subi", O::subi, F::binary, integer, integer, I::sign, rdim, X::A, "6.1"),
    row("000 110001 gg ddddd ssssssssssssssss", "subrb", O::subb, F::binary_reversed, integer, integer, I::sign, rdim, X::A, "6.1"),
    row("000 110010 gg ddddd ssssssssssssssss", "subrf", O::subf, F::binary_reversed, floating, floating, I::short_float, rdim, X::F, "6.1"),
    row("000 110011 gg ddddd ssssssssssssssss", "subri", O::subi, F::binary_reversed, integer, integer, I::sign, rdim, X::A, "6.1"),
    row("000 110100 gg ddddd ssssssssssssssss", "tstb", O::tstb, F::compare, integer, none, I::zero, rdim, X::L, "6.1"),
    row("000 110101 gg ddddd ssssssssssssssss", "xor", O::xor_, F::binary, integer, integer, I::zero, rdim, X::L, "6.1"),
    row("000 110110 gg 00000 ssssssssssssssss", "iack", O::iack, F::source, none, none, I::none, di, X::none, "6.1"),
    row("000 110111 gg ddddd ssssssssssssssss", "toieee", O::toieee, F::unary, floating, floating, I::short_float, rdim, X::ieee, "2.3", {.c4x_only = true}),
    row("000 111000 gg ddddd ssssssssssssssss", "frieee", O::frieee, F::unary, floating, floating, I::none, di, X::ieee, "2.3", {.c4x_only = true}),
    row("000 111001 gg ddddd ssssssssssssssss", "rsqrf", O::rsqrf, F::unary, floating, floating, I::short_float, rdim, X::F, "7.10", {.c4x_only = true}),
    row("000 111010 gg ddddd ssssssssssssssss", "rcpf", O::rcpf, F::unary, floating, floating, I::short_float, rdim, X::F, "7.10", {.c4x_only = true}),
    row("000 111011 gg ddddd ssssssssssssssss", "mpyshi", O::mpyshi, F::binary, integer, integer, I::sign, rdim, X::B, "6.1", {.c4x_only = true}),
    row("000 111100 gg ddddd ssssssssssssssss", "mpyuhi", O::mpyuhi, F::binary, integer, integer, mpyuhi_immediate, rdim, X::B, "6.1", {.c4x_only = true}),
    row("000 111101 gg ddddd ssssssssssssssss", "lda", O::lda, F::unary, integer, lda, I::sign, rdim, X::none, "6.1", {.write_stage = WriteStage::read, .c4x_only = true}),
    row("000 111110 11 10000 kkkkkkkkkkkkkkkk", "ldpk", O::ldpk, F::load_page, none, none, I::zero, any, X::none, "6.1", {.write_stage = WriteStage::decode, .c4x_only = true}),
    row("000 111111 11 ddddd kkkkkkkkkkkkkkkk", "ldhi", O::ldhi, F::load_constant, none, integer, I::zero, any, X::none, "6.1", {.c4x_only = true}),

    // Part-word instructions, by bits 27..23.
    row("1011 00000 gg ddddd ssssssssssssssss", "lb0", O::lb, F::unary, integer, integer, signed_part_immediate, rdim, X::L, "6.2", {.c4x_only = true}),
    row("1011 00001 gg ddddd ssssssssssssssss", "lb1", O::lb, F::unary, integer, integer, signed_part_immediate, rdim, X::L, "6.2", {.selector = 1, .c4x_only = true}),
    row("1011 00010 gg ddddd ssssssssssssssss", "lb2", O::lb, F::unary, integer, integer, signed_part_immediate, rdim, X::L, "6.2", {.selector = 2, .c4x_only = true}),
    row("1011 00011 gg ddddd ssssssssssssssss", "lb3", O::lb, F::unary, integer, integer, signed_part_immediate, rdim, X::L, "6.2", {.selector = 3, .c4x_only = true}),
    row("1011 00100 gg ddddd ssssssssssssssss", "lbu0", O::lbu, F::unary, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.c4x_only = true}),
    row("1011 00101 gg ddddd ssssssssssssssss", "lbu1", O::lbu, F::unary, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.selector = 1, .c4x_only = true}),
    row("1011 00110 gg ddddd ssssssssssssssss", "lbu2", O::lbu, F::unary, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.selector = 2, .c4x_only = true}),
    row("1011 00111 gg ddddd ssssssssssssssss", "lbu3", O::lbu, F::unary, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.selector = 3, .c4x_only = true}),
    row("1011 01000 gg ddddd ssssssssssssssss", "lwl0", O::lwl, F::binary_reversed, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.c4x_only = true}),
    row("1011 01001 gg ddddd ssssssssssssssss", "lwl1", O::lwl, F::binary_reversed, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.selector = 1, .c4x_only = true}),
    row("1011 01010 gg ddddd ssssssssssssssss", "lwl2", O::lwl, F::binary_reversed, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.selector = 2, .c4x_only = true}),
    row("1011 01011 gg ddddd ssssssssssssssss", "lwl3", O::lwl, F::binary_reversed, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.selector = 3, .c4x_only = true}),
    row("1011 01100 gg ddddd ssssssssssssssss", "lwr0", O::lwr, F::binary_reversed, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.c4x_only = true}),
    row("1011 01101 gg ddddd ssssssssssssssss", "lwr1", O::lwr, F::binary_reversed, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.selector = 1, .c4x_only = true}),
    row("1011 01110 gg ddddd ssssssssssssssss", "lwr2", O::lwr, F::binary_reversed, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.selector = 2, .c4x_only = true}),
    row("1011 01111 gg ddddd ssssssssssssssss", "lwr3", O::lwr, F::binary_reversed, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.selector = 3, .c4x_only = true}),
    row("1011 10000 gg ddddd ssssssssssssssss", "mb0", O::mb, F::binary_reversed, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.c4x_only = true}),
    row("1011 10001 gg ddddd ssssssssssssssss", "mb1", O::mb, F::binary_reversed, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.selector = 1, .c4x_only = true}),
    row("1011 10010 gg ddddd ssssssssssssssss", "mb2", O::mb, F::binary_reversed, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.selector = 2, .c4x_only = true}),
    row("1011 10011 gg ddddd ssssssssssssssss", "mb3", O::mb, F::binary_reversed, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.selector = 3, .c4x_only = true}),
    row("1011 10100 gg ddddd ssssssssssssssss", "lh0", O::lh, F::unary, integer, integer, signed_part_immediate, rdim, X::L, "6.2", {.c4x_only = true}),
    row("1011 10101 gg ddddd ssssssssssssssss", "lh1", O::lh, F::unary, integer, integer, signed_part_immediate, rdim, X::L, "6.2", {.selector = 1, .c4x_only = true}),
    row("1011 10110 gg ddddd ssssssssssssssss", "lhu0", O::lhu, F::unary, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.c4x_only = true}),
    row("1011 10111 gg ddddd ssssssssssssssss", "lhu1", O::lhu, F::unary, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.selector = 1, .c4x_only = true}),
    row("1011 11000 gg ddddd ssssssssssssssss", "mh0", O::mh, F::binary_reversed, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.c4x_only = true}),
    row("1011 11001 gg ddddd ssssssssssssssss", "mh1", O::mh, F::binary_reversed, integer, integer, other_part_immediate, rdim, X::L, "6.2", {.selector = 1, .c4x_only = true}),

    // Three-operand instructions, by bits 27..23: type 1, then type 2.
    row("001 0 00000 tt ddddd jjjjjjjj iiiiiiii", "addc3", O::addc, F::three_type1, integer, integer, I::none, any, X::A, "6.3", {.commutative = true}),
    row("001 0 00001 tt ddddd jjjjjjjj iiiiiiii", "addf3", O::addf, F::three_type1, floating, floating, I::none, any, X::F, "6.3", {.commutative = true}),
    row("001 0 00010 tt ddddd jjjjjjjj iiiiiiii", "addi3", O::addi, F::three_type1, integer, integer, I::none, any, X::A, "6.3", {.commutative = true}),
    row("001 0 00011 tt ddddd jjjjjjjj iiiiiiii", "and3", O::and_, F::three_type1, integer, integer, I::none, any, X::L, "6.3", {.commutative = true}),
    row("001 0 00100 tt ddddd jjjjjjjj iiiiiiii", "andn3", O::andn, F::three_type1, integer, integer, I::none, any, X::L, "6.3"),
    row("001 0 00101 tt ddddd jjjjjjjj iiiiiiii", "ash3", O::ash, F::three_type1, integer, integer, I::none, any, X::SA, "6.3"),
    row("001 0 00110 tt 00000 jjjjjjjj iiiiiiii", "cmpf3", O::cmpf, F::three_type1, floating, none, I::none, any, X::F, "6.3"),
    row("001 0 00111 tt 00000 jjjjjjjj iiiiiiii", "cmpi3", O::cmpi, F::three_type1, integer, none, I::none, any, X::A, "6.3"),
    row("001 0 01000 tt ddddd jjjjjjjj iiiiiiii", "lsh3", O::lsh, F::three_type1, integer, integer, I::none, any, X::S, "6.3"),
    row("001 0 01001 tt ddddd jjjjjjjj iiiiiiii", "mpyf3", O::mpyf, F::three_type1, floating, floating, I::none, any, X::F, "6.3", {.commutative = true}),
    row("001 0 01010 tt ddddd jjjjjjjj iiiiiiii", "mpyi3", O::mpyi, F::three_type1, integer, integer, I::none, any, X::B, "6.3", {.commutative = true}),
    row("001 0 01011 tt ddddd jjjjjjjj iiiiiiii", "or3", O::or_, F::three_type1, integer, integer, I::none, any, X::L, "6.3", {.commutative = true}),
    row("001 0 01100 tt ddddd jjjjjjjj iiiiiiii", "subb3", O::subb, F::three_type1, integer, integer, I::none, any, X::A, "6.3"),
    row("001 0 01101 tt ddddd jjjjjjjj iiiiiiii", "subf3", O::subf, F::three_type1, floating, floating, I::none, any, X::F, "6.3"),
    row("001 0 01110 tt ddddd jjjjjjjj iiiiiiii", "subi3", O::subi, F::three_type1, integer, integer, I::none, any, X::A, "6.3"),
    row("001 0 01111 tt 00000 jjjjjjjj iiiiiiii", "tstb3", O::tstb, F::three_type1, integer, none, I::none, any, X::L, "6.3", {.commutative = true}),
    row("001 0 10000 tt ddddd jjjjjjjj iiiiiiii", "xor3", O::xor_, F::three_type1, integer, integer, I::none, any, X::L, "6.3", {.commutative = true}),
    row("001 0 10001 tt ddddd jjjjjjjj iiiiiiii", "mpyshi3", O::mpyshi, F::three_type1, integer, integer, I::none, any, X::B, "6.3", {.commutative = true, .c4x_only = true}),
    row("001 0 10010 tt ddddd jjjjjjjj iiiiiiii", "mpyuhi3", O::mpyuhi, F::three_type1, integer, integer, I::none, any, X::B, "6.3", {.commutative = true, .c4x_only = true}),
    row("001 1 00000 tt ddddd jjjjjjjj iiiiiiii", "addc3", O::addc, F::three_type2, integer, integer, I::sign, any, X::A, "6.3", {.commutative = true, .c4x_only = true}),
    row("001 1 00001 tt ddddd jjjjjjjj iiiiiiii", "addf3", O::addf, F::three_type2, floating, floating, I::none, five_bit_only, X::F, "6.3", {.commutative = true, .c4x_only = true}),
    row("001 1 00010 tt ddddd jjjjjjjj iiiiiiii", "addi3", O::addi, F::three_type2, integer, integer, I::sign, any, X::A, "6.3", {.commutative = true, .c4x_only = true}),
    row("001 1 00011 tt ddddd jjjjjjjj iiiiiiii", "and3", O::and_, F::three_type2, integer, integer, I::sign, any, X::L, "6.3", {.commutative = true, .c4x_only = true}),
    row("001 1 00100 tt ddddd jjjjjjjj iiiiiiii", "andn3", O::andn, F::three_type2, integer, integer, I::sign, any, X::L, "6.3", {.c4x_only = true}),
    row("001 1 00101 tt ddddd jjjjjjjj iiiiiiii", "ash3", O::ash, F::three_type2, integer, integer, I::sign, any, X::SA, "6.3", {.c4x_only = true}),
    row("001 1 00110 tt zzzzz jjjjjjjj iiiiiiii", "cmpf3", O::cmpf, F::three_type2, floating, none, I::none, five_bit_only, X::F, "6.3", {.c4x_only = true}),
    row("001 1 00111 tt zzzzz jjjjjjjj iiiiiiii", "cmpi3", O::cmpi, F::three_type2, integer, none, I::sign, any, X::A, "6.3", {.c4x_only = true}),
    row("001 1 01000 tt ddddd jjjjjjjj iiiiiiii", "lsh3", O::lsh, F::three_type2, integer, integer, I::sign, any, X::S, "6.3", {.c4x_only = true}),
    row("001 1 01001 tt ddddd jjjjjjjj iiiiiiii", "mpyf3", O::mpyf, F::three_type2, floating, floating, I::none, five_bit_only, X::F, "6.3", {.commutative = true, .c4x_only = true}),
    row("001 1 01010 tt ddddd jjjjjjjj iiiiiiii", "mpyi3", O::mpyi, F::three_type2, integer, integer, I::sign, any, X::B, "6.3", {.commutative = true, .c4x_only = true}),
    row("001 1 01011 tt ddddd jjjjjjjj iiiiiiii", "or3", O::or_, F::three_type2, integer, integer, I::sign, any, X::L, "6.3", {.commutative = true, .c4x_only = true}),
    row("001 1 01100 tt ddddd jjjjjjjj iiiiiiii", "subb3", O::subb, F::three_type2, integer, integer, I::sign, any, X::A, "6.3", {.c4x_only = true}),
    row("001 1 01101 tt ddddd jjjjjjjj iiiiiiii", "subf3", O::subf, F::three_type2, floating, floating, I::none, five_bit_only, X::F, "6.3", {.c4x_only = true}),
    row("001 1 01110 tt ddddd jjjjjjjj iiiiiiii", "subi3", O::subi, F::three_type2, integer, integer, I::sign, any, X::A, "6.3", {.c4x_only = true}),
    row("001 1 01111 tt zzzzz jjjjjjjj iiiiiiii", "tstb3", O::tstb, F::three_type2, integer, none, I::sign, any, X::L, "6.3", {.commutative = true, .c4x_only = true}),
    row("001 1 10000 tt ddddd jjjjjjjj iiiiiiii", "xor3", O::xor_, F::three_type2, integer, integer, I::sign, any, X::L, "6.3", {.commutative = true, .c4x_only = true}),
    row("001 1 10001 tt ddddd jjjjjjjj iiiiiiii", "mpyshi3", O::mpyshi, F::three_type2, integer, integer, I::sign, any, X::B, "6.3", {.commutative = true, .c4x_only = true}),
    row("001 1 10010 tt ddddd jjjjjjjj iiiiiiii", "mpyuhi3", O::mpyuhi, F::three_type2, integer, integer, I::sign, any, X::B, "6.3", {.commutative = true, .c4x_only = true}),

    // Conditional loads.
    row("0100 ccccc gg ddddd ssssssssssssssss", "ldf?", O::ldf_cond, F::unary, floating, floating, I::short_float, rdim, X::none, "6.4"),
    row("0101 ccccc gg ddddd ssssssssssssssss", "ldi?", O::ldi_cond, F::unary, integer, integer, I::sign, rdim, X::none, "6.4"),

    // Program control.
    row("01100 000 vvvvvvvvvvvvvvvvvvvvvvvv", "br", O::branch, F::branch_displacement, none, none, I::none, any, X::none, "6.6", {.cycles = 4, .selector = 1}),
    row("01100 001 vvvvvvvvvvvvvvvvvvvvvvvv", "brd", O::branch, F::branch_displacement, none, none, I::none, any, X::none, "6.6", {.selector = 3, .delay = Delay::delayed}),
    row("01100 010 vvvvvvvvvvvvvvvvvvvvvvvv", "call", O::call, F::branch_displacement, none, none, I::none, any, X::none, "6.6", {.cycles = 4, .selector = 1}),
    row("01100 011 vvvvvvvvvvvvvvvvvvvvvvvv", "laj", O::laj, F::branch_displacement, none, none, I::none, any, X::none, "6.6", {.selector = 3, .delay = Delay::delayed, .c4x_only = true}),
    row("01100 100 vvvvvvvvvvvvvvvvvvvvvvvv", "rptb", O::rptb, F::branch_displacement, none, none, I::none, any, X::none, "8.3", {.cycles = 4, .selector = 1}),
    row("01100 101 vvvvvvvvvvvvvvvvvvvvvvvv", "rptbd", O::rptb, F::branch_displacement, none, none, I::none, any, X::none, "8.3", {.selector = 3, .delay = Delay::delayed, .c4x_only = true}),
    row("0110 0110 0000 0000 0000 0000 0000 0000", "swi", O::swi, F::plain, none, none, I::none, any, X::none, "6.6", {.cycles = 4}),
    row("011010 0 0 000 ccccc 00000000000 rrrrr", "b?", O::branch, F::branch_register, integer, none, I::none, any, X::none, "6.6", {.cycles = 4}),
    row("011010 1 0 000 ccccc vvvvvvvvvvvvvvvv", "b?", O::branch, F::branch_displacement, none, none, I::none, any, X::none, "6.6", {.cycles = 4, .selector = 1}),
    row("011010 0 0 001 ccccc 00000000000 rrrrr", "b?d", O::branch, F::branch_register, integer, none, I::none, any, X::none, "6.6", {.delay = Delay::delayed}),
    row("011010 1 0 001 ccccc vvvvvvvvvvvvvvvv", "b?d", O::branch, F::branch_displacement, none, none, I::none, any, X::none, "6.6", {.selector = 3, .delay = Delay::delayed}),
    row("011010 0 0 011 ccccc 00000000000 rrrrr", "b?at", O::branch, F::branch_register, integer, none, I::none, any, X::none, "6.6", {.delay = Delay::annul_if_true, .c4x_only = true}),
    row("011010 1 0 011 ccccc vvvvvvvvvvvvvvvv", "b?at", O::branch, F::branch_displacement, none, none, I::none, any, X::none, "6.6", {.selector = 3, .delay = Delay::annul_if_true, .c4x_only = true}),
    row("011010 0 0 101 ccccc 00000000000 rrrrr", "b?af", O::branch, F::branch_register, integer, none, I::none, any, X::none, "6.6", {.delay = Delay::annul_if_false, .c4x_only = true}),
    row("011010 1 0 101 ccccc vvvvvvvvvvvvvvvv", "b?af", O::branch, F::branch_displacement, none, none, I::none, any, X::none, "6.6", {.selector = 3, .delay = Delay::annul_if_false, .c4x_only = true}),
    row("011011 0 nnn 0 ccccc 00000000000 rrrrr", "db?", O::db, F::decrement_register, integer, lda, I::none, any, X::none, "6.6", {.cycles = 4, .selector = 1}),
    row("011011 1 nnn 0 ccccc vvvvvvvvvvvvvvvv", "db?", O::db, F::decrement_displacement, none, lda, I::none, any, X::none, "6.6", {.cycles = 4, .selector = 1}),
    row("011011 0 nnn 1 ccccc 00000000000 rrrrr", "db?d", O::db, F::decrement_register, integer, lda, I::none, any, X::none, "6.6", {.selector = 3, .delay = Delay::delayed}),
    row("011011 1 nnn 1 ccccc vvvvvvvvvvvvvvvv", "db?d", O::db, F::decrement_displacement, none, lda, I::none, any, X::none, "6.6", {.selector = 3, .delay = Delay::delayed}),
    row("011100 0 000 0 ccccc 00000000000 rrrrr", "call?", O::call, F::branch_register, integer, none, I::none, any, X::none, "6.6", {.cycles = 5}),
    row("011100 1 000 0 ccccc vvvvvvvvvvvvvvvv", "call?", O::call, F::branch_displacement, none, none, I::none, any, X::none, "6.6", {.cycles = 5, .selector = 1}),
    row("011100 0 000 1 ccccc 00000000000 rrrrr", "laj?", O::laj, F::branch_register, integer, none, I::none, any, X::none, "6.6", {.delay = Delay::delayed, .c4x_only = true}),
    row("011100 1 000 1 ccccc vvvvvvvvvvvvvvvv", "laj?", O::laj, F::branch_displacement, none, none, I::none, any, X::none, "6.6", {.selector = 3, .delay = Delay::delayed, .c4x_only = true}),
    row("01110100 0 00 ccccc 0000000 kkkkkkkkk", "trap?", O::trap, F::trap, none, none, I::none, any, X::none, "8.6", {.cycles = 5}),
    row("01110100 1 00 ccccc 0000000 kkkkkkkkk", "lat?", O::lat, F::trap, none, none, I::none, any, X::none, "8.6", {.delay = Delay::delayed, .c4x_only = true}),
    row("01110110 0 00 ddddd 00000000000 rrrrr", "ldep", O::ldep, F::from_expansion, none, integer, I::none, any, X::none, "6.6", {.c4x_only = true}),
    row("01110110 1 00 ddddd 00000000000 rrrrr", "ldpe", O::ldpe, F::to_expansion, integer, none, I::none, any, X::none, "6.6", {.c4x_only = true}),
    row("01111000 0 0 0 ccccc 0000000000000000", "reti?", O::reti, F::plain, none, none, I::none, any, X::none, "6.6", {.cycles = 4}),
    row("01111000 0 0 1 ccccc 0000000000000000", "reti?d", O::reti, F::plain, none, none, I::none, any, X::none, "6.6", {.delay = Delay::delayed, .c4x_only = true}),
    row("01111000 1 0 0 ccccc 0000000000000000", "rets?", O::rets, F::plain, none, none, I::none, any, X::none, "6.6", {.cycles = 4}),
    row("01111001 0 000000000000000000 rrrrr", "rptb", O::rptb, F::branch_register, integer, none, I::none, any, X::none, "8.3", {.cycles = 4, .c4x_only = true}),
    row("01111001 1 000000000000000000 rrrrr", "rptbd", O::rptb, F::branch_register, integer, none, I::none, any, X::none, "8.3", {.delay = Delay::delayed, .c4x_only = true}),

    // Multiply || add or subtract, by bits 27..24.
    pair("1000 00 00 p q xxx hhh jjjjjjjj iiiiiiii", "mpyf3", "addf3", O::mpyf, O::addf, F::multiply_add, floating, floating, I::none, any, X::multiply_add, "6.5"),
    pair("1000 00 01 p q xxx hhh jjjjjjjj iiiiiiii", "mpyf3", "addf3", O::mpyf, O::addf, F::multiply_add, floating, floating, I::none, any, X::multiply_add, "6.5", {.selector = 1}),
    pair("1000 00 10 p q xxx hhh jjjjjjjj iiiiiiii", "mpyf3", "addf3", O::mpyf, O::addf, F::multiply_add, floating, floating, I::none, any, X::multiply_add, "6.5", {.selector = 2}),
    pair("1000 00 11 p q xxx hhh jjjjjjjj iiiiiiii", "mpyf3", "addf3", O::mpyf, O::addf, F::multiply_add, floating, floating, I::none, any, X::multiply_add, "6.5", {.selector = 3}),
    pair("1000 01 00 p q xxx hhh jjjjjjjj iiiiiiii", "mpyf3", "subf3", O::mpyf, O::subf, F::multiply_add, floating, floating, I::none, any, X::multiply_add, "6.5"),
    pair("1000 01 01 p q xxx hhh jjjjjjjj iiiiiiii", "mpyf3", "subf3", O::mpyf, O::subf, F::multiply_add, floating, floating, I::none, any, X::multiply_add, "6.5", {.selector = 1}),
    pair("1000 01 10 p q xxx hhh jjjjjjjj iiiiiiii", "mpyf3", "subf3", O::mpyf, O::subf, F::multiply_add, floating, floating, I::none, any, X::multiply_add, "6.5", {.selector = 2}),
    pair("1000 01 11 p q xxx hhh jjjjjjjj iiiiiiii", "mpyf3", "subf3", O::mpyf, O::subf, F::multiply_add, floating, floating, I::none, any, X::multiply_add, "6.5", {.selector = 3}),
    pair("1000 10 00 p q xxx hhh jjjjjjjj iiiiiiii", "mpyi3", "addi3", O::mpyi, O::addi, F::multiply_add, integer, integer, I::none, any, X::multiply_add, "6.5"),
    pair("1000 10 01 p q xxx hhh jjjjjjjj iiiiiiii", "mpyi3", "addi3", O::mpyi, O::addi, F::multiply_add, integer, integer, I::none, any, X::multiply_add, "6.5", {.selector = 1}),
    pair("1000 10 10 p q xxx hhh jjjjjjjj iiiiiiii", "mpyi3", "addi3", O::mpyi, O::addi, F::multiply_add, integer, integer, I::none, any, X::multiply_add, "6.5", {.selector = 2}),
    pair("1000 10 11 p q xxx hhh jjjjjjjj iiiiiiii", "mpyi3", "addi3", O::mpyi, O::addi, F::multiply_add, integer, integer, I::none, any, X::multiply_add, "6.5", {.selector = 3}),
    pair("1000 11 00 p q xxx hhh jjjjjjjj iiiiiiii", "mpyi3", "subi3", O::mpyi, O::subi, F::multiply_add, integer, integer, I::none, any, X::multiply_add, "6.5"),
    pair("1000 11 01 p q xxx hhh jjjjjjjj iiiiiiii", "mpyi3", "subi3", O::mpyi, O::subi, F::multiply_add, integer, integer, I::none, any, X::multiply_add, "6.5", {.selector = 1}),
    pair("1000 11 10 p q xxx hhh jjjjjjjj iiiiiiii", "mpyi3", "subi3", O::mpyi, O::subi, F::multiply_add, integer, integer, I::none, any, X::multiply_add, "6.5", {.selector = 2}),
    pair("1000 11 11 p q xxx hhh jjjjjjjj iiiiiiii", "mpyi3", "subi3", O::mpyi, O::subi, F::multiply_add, integer, integer, I::none, any, X::multiply_add, "6.5", {.selector = 3}),

    // Operation || store, load || load, store || store, by bits 29..25.
    pair("11 00000 aaa 000 eee jjjjjjjj iiiiiiii", "stf", "stf", O::stf, O::stf, F::store_store, floating, none, I::none, any, X::none, "6.5"),
    pair("11 00001 aaa 000 eee jjjjjjjj iiiiiiii", "sti", "sti", O::sti, O::sti, F::store_store, integer, none, I::none, any, X::none, "6.5"),
    pair("11 00010 aaa bbb 000 jjjjjjjj iiiiiiii", "ldf", "ldf", O::ldf, O::ldf, F::load_load, none, floating, I::none, any, X::none, "6.5"),
    pair("11 00011 aaa bbb 000 jjjjjjjj iiiiiiii", "ldi", "ldi", O::ldi, O::ldi, F::load_load, none, integer, I::none, any, X::none, "6.5"),
    pair("11 00100 aaa 000 eee jjjjjjjj iiiiiiii", "absf", "stf", O::absf, O::stf, F::op2_store, floating, floating, I::none, any, X::F, "6.5"),
    pair("11 00101 aaa 000 eee jjjjjjjj iiiiiiii", "absi", "sti", O::absi, O::sti, F::op2_store, integer, integer, I::none, any, X::B, "6.5"),
    pair("11 00110 aaa bbb eee jjjjjjjj iiiiiiii", "addf3", "stf", O::addf, O::stf, F::op3_store, floating, floating, I::none, any, X::F, "6.5", {.commutative = true}),
    pair("11 00111 aaa bbb eee jjjjjjjj iiiiiiii", "addi3", "sti", O::addi, O::sti, F::op3_store, integer, integer, I::none, any, X::A, "6.5", {.commutative = true}),
    pair("11 01000 aaa bbb eee jjjjjjjj iiiiiiii", "and3", "sti", O::and_, O::sti, F::op3_store, integer, integer, I::none, any, X::L, "6.5", {.commutative = true}),
    pair("11 01001 aaa bbb eee jjjjjjjj iiiiiiii", "ash3", "sti", O::ash, O::sti, F::op3_store_reversed, integer, integer, I::none, any, X::SA, "6.5"),
    pair("11 01010 aaa 000 eee jjjjjjjj iiiiiiii", "fix", "sti", O::fix, O::sti, F::op2_store, integer, integer, I::none, any, X::B, "6.5"),
    pair("11 01011 aaa 000 eee jjjjjjjj iiiiiiii", "float", "stf", O::float_, O::stf, F::op2_store, floating, floating, I::none, any, X::G, "6.5"),
    pair("11 01100 aaa 000 eee jjjjjjjj iiiiiiii", "ldf", "stf", O::ldf, O::stf, F::op2_store, floating, floating, I::none, any, X::none, "6.5"),
    pair("11 01101 aaa 000 eee jjjjjjjj iiiiiiii", "ldi", "sti", O::ldi, O::sti, F::op2_store, integer, integer, I::none, any, X::none, "6.5"),
    pair("11 01110 aaa bbb eee jjjjjjjj iiiiiiii", "lsh3", "sti", O::lsh, O::sti, F::op3_store_reversed, integer, integer, I::none, any, X::S, "6.5"),
    pair("11 01111 aaa bbb eee jjjjjjjj iiiiiiii", "mpyf3", "stf", O::mpyf, O::stf, F::op3_store, floating, floating, I::none, any, X::F, "6.5", {.commutative = true}),
    pair("11 10000 aaa bbb eee jjjjjjjj iiiiiiii", "mpyi3", "sti", O::mpyi, O::sti, F::op3_store, integer, integer, I::none, any, X::B, "6.5", {.commutative = true}),
    pair("11 10001 aaa 000 eee jjjjjjjj iiiiiiii", "negf", "stf", O::negf, O::stf, F::op2_store, floating, floating, I::none, any, X::F, "6.5"),
    pair("11 10010 aaa 000 eee jjjjjjjj iiiiiiii", "negi", "sti", O::negi, O::sti, F::op2_store, integer, integer, I::none, any, X::A, "6.5"),
    pair("11 10011 aaa 000 eee jjjjjjjj iiiiiiii", "not", "sti", O::not_, O::sti, F::op2_store, integer, integer, I::none, any, X::L, "6.5"),
    pair("11 10100 aaa bbb eee jjjjjjjj iiiiiiii", "or3", "sti", O::or_, O::sti, F::op3_store, integer, integer, I::none, any, X::L, "6.5", {.commutative = true}),
    pair("11 10101 aaa bbb eee jjjjjjjj iiiiiiii", "subf3", "stf", O::subf, O::stf, F::op3_store_reversed, floating, floating, I::none, any, X::F, "6.5"),
    pair("11 10110 aaa bbb eee jjjjjjjj iiiiiiii", "subi3", "sti", O::subi, O::sti, F::op3_store_reversed, integer, integer, I::none, any, X::A, "6.5"),
    pair("11 10111 aaa bbb eee jjjjjjjj iiiiiiii", "xor3", "sti", O::xor_, O::sti, F::op3_store, integer, integer, I::none, any, X::L, "6.5", {.commutative = true}),
    pair("11 11000 aaa 000 eee jjjjjjjj iiiiiiii", "toieee", "stf", O::toieee, O::stf, F::op2_store, floating, floating, I::none, any, X::ieee, "6.5", {.c4x_only = true}),
    pair("11 11001 aaa 000 eee jjjjjjjj iiiiiiii", "frieee", "stf", O::frieee, O::stf, F::op2_store, floating, floating, I::none, any, X::ieee, "6.5", {.c4x_only = true}),
};
// clang-format on

// clang-format off
constexpr std::array c3x_forms{
    // C31 from revision 5, C32 and C33 have IDLE2. All but the C33 have the two after it.
    row("000 001100 00 00000 0000000000000001", "idle2", O::idle2, F::plain, none, none, I::none, any, X::none, "9"),
    row("000 100001 00 00000 0000000000000000", "maxspeed", O::maxspeed, F::plain, none, none, I::none, any, X::none, "9"),
    row("000 100001 00 00000 0000000000000001", "lopower", O::lopower, F::plain, none, none, I::none, any, X::none, "9"),
    row("000 101100 00 00000 0000000000000000", "sigi", O::sigi, F::plain, none, none, I::none, any, X::none, "9"),
    row("01100 000 vvvvvvvvvvvvvvvvvvvvvvvv", "br", O::branch, F::branch_absolute, none, none, I::none, any, X::none, "9", {.cycles = 4}),
    row("01100 001 vvvvvvvvvvvvvvvvvvvvvvvv", "brd", O::branch, F::branch_absolute, none, none, I::none, any, X::none, "9", {.delay = Delay::delayed}),
    row("01100 010 vvvvvvvvvvvvvvvvvvvvvvvv", "call", O::call, F::branch_absolute, none, none, I::none, any, X::none, "9", {.cycles = 4}),
    row("01100 100 vvvvvvvvvvvvvvvvvvvvvvvv", "rptb", O::rptb, F::branch_absolute, none, none, I::none, any, X::none, "9", {.cycles = 4}),
    row("01110100 0 00 ccccc 0000000000 1 kkkkk", "trap?", O::trap, F::trap, none, none, I::none, any, X::none, "9", {.cycles = 5}),
};
// clang-format on

/// Whether the C3x has the same encoding.
constexpr bool is_common(const Row& row) {
  const bool other_branch = row.format == Format::branch_displacement && row.bits.field('v').width == 24;
  return !row.c4x_only && !other_branch && row.operation != Operation::trap;
}

constexpr auto c3x_table = [] {
  constexpr std::size_t common = static_cast<std::size_t>(std::ranges::count_if(table, is_common));
  std::array<Row, common + c3x_forms.size()> out{};
  std::ranges::copy(c3x_forms, std::ranges::copy_if(table, out.begin(), is_common).out);
  return out;
}();

constexpr bool overlap(const Row& a, const Row& b) {
  if (((a.bits.match ^ b.bits.match) & a.bits.mask & b.bits.mask) != 0) return false;
  return (a.modes & b.modes) != 0;
}

constexpr bool are_disjoint(std::span<const Row> rows) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t k = i + 1; k < rows.size(); ++k)
      if (overlap(rows[i], rows[k])) return false;
  return true;
}
static_assert(are_disjoint(table), "two rows of the instruction table claim the same word");
static_assert(are_disjoint(c3x_table), "two rows of the C3x's instruction table claim the same word");

}  // namespace

std::span<const Row> rows(Cpu cpu) { return cpu == Cpu::c40 ? std::span<const Row>(table) : c3x_table; }

}  // namespace isa
