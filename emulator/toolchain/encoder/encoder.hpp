#pragma once
// Instructions as written to words, by the rows of the instruction table.
#include <functional>
#include <string_view>

#include "isa/types.hpp"
#include "toolchain/objects/object.hpp"
#include "toolchain/syntax/diagnostics.hpp"
#include "toolchain/syntax/dialect.hpp"
#include "toolchain/syntax/parser.hpp"

namespace toolchain {

/// A field of the word that the linker has to settle, and what it stands for.
struct FieldRelocation {
  RelocationType type = RelocationType::rellong;
  Value target;
};

struct EncodeContext {
  isa::Address pc = 0;
  const SymbolSource& symbols;                              ///< Placed, unless `relocations` is given.
  const std::function<void(const LineError&)>& on_warning;  ///< For what is odd but has a meaning.
  /// Of a relocatable object: addresses count from their sections' starts, and what they need is added here.
  std::vector<FieldRelocation>* relocations = nullptr;
  int section = Value::absolute;  ///< That the word lies in.
  Dialect dialect = Dialect::ti;
  isa::Cpu cpu = isa::Cpu::c40;
};

/// Whether any instruction has this name (lower case).
bool is_mnemonic(std::string_view name, isa::Cpu cpu);

/// `second` is the other half of a parallel instruction or null. Where several encodings fit, the first of: general
/// addressing, three-operand type 1, type 2, operands of a commutative operation exchanged. Throws LineError.
isa::Word encode(const HalfSyntax& first, const HalfSyntax* second, const EncodeContext& context);

}  // namespace toolchain
