#pragma once
// Which of the 2^32 words are instructions of the TMS320C4x, written from the reference text (c40-isa.md 3, 4, 6, 12)
// by itself.
#include <cstdint>

namespace reference {

bool is_instruction(std::uint32_t word);

}  // namespace reference
