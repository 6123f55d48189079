#pragma once
// Disassembly: text that assembles to the same words.
#include <functional>
#include <string>

#include "isa/decode.hpp"

namespace isa {

/// The name of a code address, or an empty string.
using SymbolLookup = std::function<std::string(Address)>;

/// `pc` is the word's address, needed for branch targets. Reserved words give `.word 0x...`. Parallel instructions are
/// on one line, separated by " || ".
///
/// If one text could mean two words, `=` marks the rarer word and means "exactly this field": `*+ar0(=1)` is the type-2
/// form of a displacement that type 1 has too, `ldf =0x8001,r0` a short float that no decimal number gives.
std::string disassemble(Word word, Address pc, const SymbolLookup& symbols = {}, Cpu cpu = Cpu::c40);
/// `cpu` is the processor for which the instruction was decoded.
std::string disassemble(const Instruction& instruction, Address pc, const SymbolLookup& symbols = {},
                        Cpu cpu = Cpu::c40);

}  // namespace isa
