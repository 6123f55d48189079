#pragma once
// Encodes instructions: from text to words, by the rows of the instruction table.
#include <functional>
#include <string_view>

#include "isa/types.hpp"
#include "toolchain/objects/object.hpp"
#include "toolchain/syntax/diagnostics.hpp"
#include "toolchain/syntax/dialect.hpp"
#include "toolchain/syntax/parser.hpp"

namespace toolchain {

/// A field of the word that the linker has to fill, and what it refers to.
struct FieldRelocation {
  RelocationType type = RelocationType::rellong;
  Value target;
};

struct EncodeContext {
  isa::Address pc = 0;
  const SymbolSource& symbols;                              ///< With addresses, unless `relocations` is given.
  const std::function<void(const LineError&)>& on_warning;  ///< For unusual text that has a meaning.
  /// For a relocatable object: addresses count from the starts of their sections, and the relocations are added here.
  std::vector<FieldRelocation>* relocations = nullptr;
  int section = Value::absolute;  ///< The section of the word.
  Dialect dialect = Dialect::ti;
  isa::Cpu cpu = isa::Cpu::c40;
};

/// Whether any instruction has this name (lower case).
bool is_mnemonic(std::string_view name, isa::Cpu cpu);

/// `second` is the other half of a parallel instruction or null. If several encodings fit, the first of these is taken:
/// general addressing, three-operand type 1, type 2, operands of a commutative operation exchanged. Throws LineError.
isa::Word encode(const HalfSyntax& first, const HalfSyntax* second, const EncodeContext& context);

}  // namespace toolchain
