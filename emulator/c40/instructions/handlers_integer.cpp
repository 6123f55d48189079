#include "c40/instructions/handler_tables.hpp"
#include "c40/instructions/handlers.hpp"

namespace c40::execute {
namespace {

using isa::Operation;

template <bool flags>
Handler binary_handler(Operation operation, Kind a, Kind b) {
  using namespace integer;
  switch (operation) {
    case Operation::addi: return two_sources<IntegerForm<Addi, flags>>(a, b);
    case Operation::addc: return two_sources<IntegerForm<Addc, flags>>(a, b);
    case Operation::subi: return two_sources<IntegerForm<Subi, flags>>(a, b);
    case Operation::subb: return two_sources<IntegerForm<Subb, flags>>(a, b);
    case Operation::and_: return two_sources<IntegerForm<And, flags>>(a, b);
    case Operation::andn: return two_sources<IntegerForm<Andn, flags>>(a, b);
    case Operation::or_: return two_sources<IntegerForm<Or, flags>>(a, b);
    case Operation::xor_: return two_sources<IntegerForm<Xor, flags>>(a, b);
    case Operation::lsh: return two_sources<IntegerForm<Lsh, flags>>(a, b);
    case Operation::ash: return two_sources<IntegerForm<Ash, flags>>(a, b);
    case Operation::mpyi: return two_sources<IntegerForm<Mpyi, flags>>(a, b);
    case Operation::mpyshi: return two_sources<IntegerForm<Mpyshi, flags>>(a, b);
    case Operation::mpyuhi: return two_sources<IntegerForm<Mpyuhi, flags>>(a, b);
    case Operation::lwl: return two_sources<IntegerForm<Lwl, flags>>(a, b);
    case Operation::lwr: return two_sources<IntegerForm<Lwr, flags>>(a, b);
    case Operation::mb: return two_sources<IntegerForm<Mb, flags>>(a, b);
    case Operation::mh: return two_sources<IntegerForm<Mh, flags>>(a, b);
    case Operation::subc: return two_sources<IntegerForm<Subc, false>>(a, b);
    case Operation::cmpi: return two_sources<IntegerForm<Cmpi, true>>(a, b);
    case Operation::tstb: return two_sources<IntegerForm<Tstb, true>>(a, b);
    default: return nullptr;
  }
}

template <bool flags>
Handler unary_handler(Operation operation, Kind a) {
  using namespace integer;
  switch (operation) {
    case Operation::ldi:
    case Operation::ldii:
    case Operation::sigi: return one_source<IntegerForm<Ldi, flags>>(a);
    case Operation::absi: return one_source<IntegerForm<Absi, flags>>(a);
    case Operation::negi: return one_source<IntegerForm<Negi, flags>>(a);
    case Operation::negb: return one_source<IntegerForm<Negb, flags>>(a);
    case Operation::not_: return one_source<IntegerForm<Not, flags>>(a);
    case Operation::lb: return one_source<IntegerForm<Lb, flags>>(a);
    case Operation::lbu: return one_source<IntegerForm<Lbu, flags>>(a);
    case Operation::lh: return one_source<IntegerForm<Lh, flags>>(a);
    case Operation::lhu: return one_source<IntegerForm<Lhu, flags>>(a);
    case Operation::rol: return &compute<IntegerForm<Rol, flags>, Kind::reg, Kind::none, NoStore>;
    case Operation::rolc: return &compute<IntegerForm<Rolc, flags>, Kind::reg, Kind::none, NoStore>;
    case Operation::ror: return &compute<IntegerForm<Ror, flags>, Kind::reg, Kind::none, NoStore>;
    case Operation::rorc: return &compute<IntegerForm<Rorc, flags>, Kind::reg, Kind::none, NoStore>;
    case Operation::ldhi: return &compute<IntegerForm<Ldhi, false>, Kind::constant, Kind::none, NoStore>;
    case Operation::lda:
    case Operation::ldpk: return one_source<IntegerForm<Lda, false>>(a);
    default: return nullptr;
  }
}

}  // namespace

Handler integer_handler(Operation operation, Kind a, Kind b, bool flags) {
  if (b == Kind::none) return flags ? unary_handler<true>(operation, a) : unary_handler<false>(operation, a);
  return flags ? binary_handler<true>(operation, a, b) : binary_handler<false>(operation, a, b);
}

Handler integer_store_handler(Operation operation, Kind a, Kind b) {
  using namespace integer;
  switch (operation) {
    case Operation::absi: return with_store<IntegerForm<Absi, true>, false>(a, b);
    case Operation::addi: return with_store<IntegerForm<Addi, true>, false>(a, b);
    case Operation::and_: return with_store<IntegerForm<And, true>, false>(a, b);
    case Operation::ash: return with_store<IntegerForm<Ash, true>, false>(a, b);
    case Operation::ldi: return with_store<IntegerForm<Ldi, false>, false>(a, b);
    case Operation::lsh: return with_store<IntegerForm<Lsh, true>, false>(a, b);
    case Operation::mpyi: return with_store<IntegerForm<Mpyi, true>, false>(a, b);
    case Operation::negi: return with_store<IntegerForm<Negi, true>, false>(a, b);
    case Operation::not_: return with_store<IntegerForm<Not, true>, false>(a, b);
    case Operation::or_: return with_store<IntegerForm<Or, true>, false>(a, b);
    case Operation::subi: return with_store<IntegerForm<Subi, true>, false>(a, b);
    case Operation::xor_: return with_store<IntegerForm<Xor, true>, false>(a, b);
    default: return nullptr;
  }
}

}  // namespace c40::execute
