#pragma once
// Operations, one row each: the name, and what computes it. docs/how-to/one-instruction.md follows one from row to
// flags.
#include <string_view>

#include "isa/table.hpp"

namespace isa {

/// The group of handlers of the chip to which an operation belongs.
enum class OperationKind : std::uint8_t {
  integer,   ///< a body of c40/integer.hpp, or a move of integers
  floating,  ///< a body on 40-bit floats, or a move of them
  control    ///< branches, the stack, repeats, IDLE and the like: c40/handlers_control.cpp
};

struct OperationRow {
  Operation operation;
  std::string_view name;
  OperationKind kind;
};

const OperationRow& operation_row(Operation operation);

}  // namespace isa
