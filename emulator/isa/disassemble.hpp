#pragma once
// Words to text that assembles to the same words.
#include <functional>
#include <string>

#include "isa/decode.hpp"

namespace isa {

/// The name of a code address, or an empty string.
using SymbolLookup = std::function<std::string(Address)>;

/// `pc` is the address of the word, needed for branch targets. Reserved words give `.word 0x...`. Parallel instructions
/// stand on one line, separated by " || ".
///
/// Where one text could stand for two words, the rarer one is marked by `=`, "exactly this field": `*+ar0(=1)` is the
/// type-2 form of a displacement that type 1 has too, `ldf =0x8001,r0` a short float that no decimal number gives.
std::string disassemble(Word word, Address pc, const SymbolLookup& symbols = {}, Cpu cpu = Cpu::c40);
/// `cpu` is the one that the instruction was decoded for.
std::string disassemble(const Instruction& instruction, Address pc, const SymbolLookup& symbols = {},
                        Cpu cpu = Cpu::c40);

}  // namespace isa
