#include "isa/operations.hpp"

namespace isa {
namespace {

constexpr bool are_in_order() {
  for (std::size_t i = 0; i < operation_rows.size(); ++i)
    if (operation_rows[i].operation != static_cast<Operation>(i) || operation_rows[i].name.empty()) return false;
  return operation_rows.back().operation == Operation::maxspeed;
}
static_assert(are_in_order(), "each operation has one row, in the order of the enumeration");

}  // namespace
}  // namespace isa
