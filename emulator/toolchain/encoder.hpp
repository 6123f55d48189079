#pragma once
// Instructions as written to words, by the rows of the instruction table.
#include <functional>
#include <string_view>

#include "isa/types.hpp"
#include "toolchain/diagnostics.hpp"
#include "toolchain/parser.hpp"

namespace toolchain {

struct EncodeContext {
  isa::Address pc = 0;
  const SymbolSource& symbols;                              ///< Placed.
  const std::function<void(const LineError&)>& on_warning;  ///< For what is odd but has a meaning.
};

/// Whether any instruction has this name (lower case).
bool is_mnemonic(std::string_view name);

/// `second` is the other half of a parallel instruction or null. Where several encodings fit, the first of: general
/// addressing, three-operand type 1, type 2, operands of a commutative operation exchanged. Throws LineError.
isa::Word encode(const HalfSyntax& first, const HalfSyntax* second, const EncodeContext& context);

}  // namespace toolchain
