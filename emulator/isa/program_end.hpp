#pragma once
// How a program ends: IDLE, or an unconditional branch to itself.
#include "isa/word.hpp"

namespace isa {

enum class ProgramEnd : std::uint8_t { none, idle, halt };

/// The kind of end that an instruction may be. A displacement counts from the next word.
constexpr ProgramEnd program_end(Word word) {
  constexpr Word idle = 0x06000000u, idle2 = 0x06000001u, branch_to_itself = 0x6A00FFFFu,
                 long_branch_to_itself = 0x60FFFFFFu;
  if (word == branch_to_itself || word == long_branch_to_itself) return ProgramEnd::halt;
  return word == idle || word == idle2 ? ProgramEnd::idle : ProgramEnd::none;
}

}  // namespace isa
