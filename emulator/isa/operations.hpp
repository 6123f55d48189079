#pragma once
// Operations, one row each: the name, and what computes it. docs/how-to/one-instruction.md follows one from row to
// flags.
#include <array>
#include <cstdint>
#include <string_view>

namespace isa {

// clang-format off
/// What one half of an instruction computes. Encodings with the same meaning share one operation: ADDI, ADDI3 and the
/// first half of ADDI3 || STI are `addi`; SUBRI is `subi` with its sources exchanged; STIK is `sti` of an immediate.
enum class Operation : std::uint8_t {
  none,
  absf, absi, addc, addf, addi, and_, andn, ash, cmpf, cmpi, fix, float_, lde, ldf, ldfi, ldi, ldii, ldm, lsh,
  mpyf, mpyi, mpyshi, mpyuhi, negb, negf, negi, norm, not_, or_, rnd, rol, rolc, ror, rorc, sigi,
  subb, subc, subf, subi, tstb, xor_, toieee, frieee, rsqrf, rcpf,
  lda, ldpk, ldhi, ldep, ldpe, ldf_cond, ldi_cond,
  lb, lbu, lh, lhu, lwl, lwr, mb, mh,
  stf, stfi, sti, stii, pop, popf, push, pushf,
  nop, idle, idle2, swi, iack, rpts, rptb,
  branch, db, call, laj, rets, reti, trap, lat,
  lopower, maxspeed,  // C3x only.
};
// clang-format on

/// The group of handlers of the chip to which an operation belongs.
enum class OperationKind : std::uint8_t {
  integer,   ///< a body of c40/values/integer.hpp, or a move of integers
  floating,  ///< a body on 40-bit floats, or a move of them
  control    ///< branches, the stack, repeats, IDLE and the like: c40/instructions/handlers_control.cpp
};

struct OperationRow {
  Operation operation;
  std::string_view name;
  OperationKind kind;
};

// clang-format off
inline constexpr auto operation_rows = std::to_array<OperationRow>({
    {Operation::none, "none", OperationKind::integer},
    {Operation::absf, "absf", OperationKind::floating},
    {Operation::absi, "absi", OperationKind::integer},
    {Operation::addc, "addc", OperationKind::integer},
    {Operation::addf, "addf", OperationKind::floating},
    {Operation::addi, "addi", OperationKind::integer},
    {Operation::and_, "and", OperationKind::integer},
    {Operation::andn, "andn", OperationKind::integer},
    {Operation::ash, "ash", OperationKind::integer},
    {Operation::cmpf, "cmpf", OperationKind::floating},
    {Operation::cmpi, "cmpi", OperationKind::integer},
    {Operation::fix, "fix", OperationKind::floating},
    {Operation::float_, "float", OperationKind::floating},
    {Operation::lde, "lde", OperationKind::floating},
    {Operation::ldf, "ldf", OperationKind::floating},
    {Operation::ldfi, "ldfi", OperationKind::floating},
    {Operation::ldi, "ldi", OperationKind::integer},
    {Operation::ldii, "ldii", OperationKind::integer},
    {Operation::ldm, "ldm", OperationKind::floating},
    {Operation::lsh, "lsh", OperationKind::integer},
    {Operation::mpyf, "mpyf", OperationKind::floating},
    {Operation::mpyi, "mpyi", OperationKind::integer},
    {Operation::mpyshi, "mpyshi", OperationKind::integer},
    {Operation::mpyuhi, "mpyuhi", OperationKind::integer},
    {Operation::negb, "negb", OperationKind::integer},
    {Operation::negf, "negf", OperationKind::floating},
    {Operation::negi, "negi", OperationKind::integer},
    {Operation::norm, "norm", OperationKind::floating},
    {Operation::not_, "not", OperationKind::integer},
    {Operation::or_, "or", OperationKind::integer},
    {Operation::rnd, "rnd", OperationKind::floating},
    {Operation::rol, "rol", OperationKind::integer},
    {Operation::rolc, "rolc", OperationKind::integer},
    {Operation::ror, "ror", OperationKind::integer},
    {Operation::rorc, "rorc", OperationKind::integer},
    {Operation::sigi, "sigi", OperationKind::integer},
    {Operation::subb, "subb", OperationKind::integer},
    {Operation::subc, "subc", OperationKind::integer},
    {Operation::subf, "subf", OperationKind::floating},
    {Operation::subi, "subi", OperationKind::integer},
    {Operation::tstb, "tstb", OperationKind::integer},
    {Operation::xor_, "xor", OperationKind::integer},
    {Operation::toieee, "toieee", OperationKind::floating},
    {Operation::frieee, "frieee", OperationKind::floating},
    {Operation::rsqrf, "rsqrf", OperationKind::floating},
    {Operation::rcpf, "rcpf", OperationKind::floating},
    {Operation::lda, "lda", OperationKind::integer},
    {Operation::ldpk, "ldpk", OperationKind::integer},
    {Operation::ldhi, "ldhi", OperationKind::integer},
    {Operation::ldep, "ldep", OperationKind::control},
    {Operation::ldpe, "ldpe", OperationKind::control},
    {Operation::ldf_cond, "ldf_cond", OperationKind::floating},
    {Operation::ldi_cond, "ldi_cond", OperationKind::integer},
    {Operation::lb, "lb", OperationKind::integer},
    {Operation::lbu, "lbu", OperationKind::integer},
    {Operation::lh, "lh", OperationKind::integer},
    {Operation::lhu, "lhu", OperationKind::integer},
    {Operation::lwl, "lwl", OperationKind::integer},
    {Operation::lwr, "lwr", OperationKind::integer},
    {Operation::mb, "mb", OperationKind::integer},
    {Operation::mh, "mh", OperationKind::integer},
    {Operation::stf, "stf", OperationKind::floating},
    {Operation::stfi, "stfi", OperationKind::floating},
    {Operation::sti, "sti", OperationKind::integer},
    {Operation::stii, "stii", OperationKind::integer},
    {Operation::pop, "pop", OperationKind::control},
    {Operation::popf, "popf", OperationKind::control},
    {Operation::push, "push", OperationKind::control},
    {Operation::pushf, "pushf", OperationKind::control},
    {Operation::nop, "nop", OperationKind::control},
    {Operation::idle, "idle", OperationKind::control},
    {Operation::idle2, "idle2", OperationKind::control},
    {Operation::swi, "swi", OperationKind::control},
    {Operation::iack, "iack", OperationKind::control},
    {Operation::rpts, "rpts", OperationKind::control},
    {Operation::rptb, "rptb", OperationKind::control},
    {Operation::branch, "branch", OperationKind::control},
    {Operation::db, "db", OperationKind::control},
    {Operation::call, "call", OperationKind::control},
    {Operation::laj, "laj", OperationKind::control},
    {Operation::rets, "rets", OperationKind::control},
    {Operation::reti, "reti", OperationKind::control},
    {Operation::trap, "trap", OperationKind::control},
    {Operation::lat, "lat", OperationKind::control},
    {Operation::lopower, "lopower", OperationKind::integer},
    {Operation::maxspeed, "maxspeed", OperationKind::integer},
});
// clang-format on

constexpr const OperationRow& operation_row(Operation operation) {
  return operation_rows[static_cast<std::size_t>(operation)];
}
constexpr std::string_view name(Operation operation) { return operation_row(operation).name; }

}  // namespace isa
