#include "isa/operations.hpp"

namespace isa {
namespace {

using O = Operation;
using B = OperationKind;

// clang-format off
constexpr std::array<OperationRow, operation_count> operations{{
    {O::none, "none", B::integer},
    {O::absf, "absf", B::floating},
    {O::absi, "absi", B::integer},
    {O::addc, "addc", B::integer},
    {O::addf, "addf", B::floating},
    {O::addi, "addi", B::integer},
    {O::and_, "and", B::integer},
    {O::andn, "andn", B::integer},
    {O::ash, "ash", B::integer},
    {O::cmpf, "cmpf", B::floating},
    {O::cmpi, "cmpi", B::integer},
    {O::fix, "fix", B::floating},
    {O::float_, "float", B::floating},
    {O::lde, "lde", B::floating},
    {O::ldf, "ldf", B::floating},
    {O::ldfi, "ldfi", B::floating},
    {O::ldi, "ldi", B::integer},
    {O::ldii, "ldii", B::integer},
    {O::ldm, "ldm", B::floating},
    {O::lsh, "lsh", B::integer},
    {O::mpyf, "mpyf", B::floating},
    {O::mpyi, "mpyi", B::integer},
    {O::mpyshi, "mpyshi", B::integer},
    {O::mpyuhi, "mpyuhi", B::integer},
    {O::negb, "negb", B::integer},
    {O::negf, "negf", B::floating},
    {O::negi, "negi", B::integer},
    {O::norm, "norm", B::floating},
    {O::not_, "not", B::integer},
    {O::or_, "or", B::integer},
    {O::rnd, "rnd", B::floating},
    {O::rol, "rol", B::integer},
    {O::rolc, "rolc", B::integer},
    {O::ror, "ror", B::integer},
    {O::rorc, "rorc", B::integer},
    {O::sigi, "sigi", B::integer},
    {O::subb, "subb", B::integer},
    {O::subc, "subc", B::integer},
    {O::subf, "subf", B::floating},
    {O::subi, "subi", B::integer},
    {O::tstb, "tstb", B::integer},
    {O::xor_, "xor", B::integer},
    {O::toieee, "toieee", B::floating},
    {O::frieee, "frieee", B::floating},
    {O::rsqrf, "rsqrf", B::floating},
    {O::rcpf, "rcpf", B::floating},
    {O::lda, "lda", B::integer},
    {O::ldpk, "ldpk", B::integer},
    {O::ldhi, "ldhi", B::integer},
    {O::ldep, "ldep", B::control},
    {O::ldpe, "ldpe", B::control},
    {O::ldf_cond, "ldf_cond", B::floating},
    {O::ldi_cond, "ldi_cond", B::integer},
    {O::lb, "lb", B::integer},
    {O::lbu, "lbu", B::integer},
    {O::lh, "lh", B::integer},
    {O::lhu, "lhu", B::integer},
    {O::lwl, "lwl", B::integer},
    {O::lwr, "lwr", B::integer},
    {O::mb, "mb", B::integer},
    {O::mh, "mh", B::integer},
    {O::stf, "stf", B::floating},
    {O::stfi, "stfi", B::floating},
    {O::sti, "sti", B::integer},
    {O::stii, "stii", B::integer},
    {O::pop, "pop", B::control},
    {O::popf, "popf", B::control},
    {O::push, "push", B::control},
    {O::pushf, "pushf", B::control},
    {O::nop, "nop", B::control},
    {O::idle, "idle", B::control},
    {O::idle2, "idle2", B::control},
    {O::swi, "swi", B::control},
    {O::iack, "iack", B::control},
    {O::rpts, "rpts", B::control},
    {O::rptb, "rptb", B::control},
    {O::branch, "branch", B::control},
    {O::db, "db", B::control},
    {O::call, "call", B::control},
    {O::laj, "laj", B::control},
    {O::rets, "rets", B::control},
    {O::reti, "reti", B::control},
    {O::trap, "trap", B::control},
    {O::lat, "lat", B::control},
    {O::lopower, "lopower", B::integer},
    {O::maxspeed, "maxspeed", B::integer},
}};
// clang-format on

constexpr bool are_in_order() {
  for (std::size_t i = 0; i < operations.size(); ++i)
    if (operations[i].operation != static_cast<Operation>(i) || operations[i].name.empty()) return false;
  return true;
}
static_assert(are_in_order(), "each operation has one row, in the order of the enumeration");

}  // namespace

const OperationRow& operation_row(Operation operation) { return operations[static_cast<std::size_t>(operation)]; }

std::string_view name(Operation operation) { return operation_row(operation).name; }

}  // namespace isa
