#pragma once
// Basic types of the chip: cycles, and the causes of cycles.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "isa/types.hpp"

namespace c40 {

using isa::Address;
using isa::Word;

/// H1 periods: one H1 period is one instruction cycle, two CLKIN periods (c40-hardware.md 0.3).
using Cycles = std::int64_t;

/// The cause of a cycle. Every cycle of a chip has exactly one cause.
enum class Cause : std::uint8_t {
  execute,            ///< an instruction advanced
  branch,             ///< the pipeline refills after a standard branch, call, return, trap or repeat set-up
  register_conflict,  ///< address generation waited for a register
  memory_conflict,    ///< on-chip port or bus taken by another access of the processor
  dma_conflict,       ///< on-chip port or bus taken by the DMA coprocessor
  cache_miss,         ///< the instruction cache did not have the word
  wait_state,         ///< wait states of a region
  bus_arbitration,    ///< waited for a shared bus (reported by the machine)
  bus_transfer,       ///< waited for a shared bus to move the word (reported by the machine)
  comm_port,          ///< waited for a communication port
  interrupt,          ///< interrupt entry
  idle,               ///< IDLE
  halted              ///< held in reset, or stopped by a fault
};
inline constexpr std::size_t cause_count = 13;
using Causes = std::array<Cycles, cause_count>;

constexpr std::string_view name(Cause cause) {
  constexpr std::array<std::string_view, cause_count> names{
      "execute",    "branch",          "register_conflict", "memory_conflict", "dma_conflict", "cache_miss",
      "wait_state", "bus_arbitration", "bus_transfer",      "comm_port",       "interrupt",    "idle",
      "halted"};
  return names[static_cast<std::size_t>(cause)];
}

}  // namespace c40
