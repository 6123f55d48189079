#pragma once
// Basic types of the chip: cycles, and the causes of cycles.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "isa/word.hpp"

namespace c40 {

using isa::Address;
using isa::Word;

/// H1 periods: one H1 period is one instruction cycle, two CLKIN periods (c40-hardware.md 0.3).
using Cycles = std::int64_t;

/// The cause of a cycle. Every cycle of a chip has exactly one cause. The pipeline model (timing.hpp) books the causes
/// up to wait_state, and they alone are in a block's constants.
enum class Cause : std::uint8_t {
  execute,
  branch,
  register_conflict,
  memory_conflict,
  dma_conflict,
  cache_miss,
  wait_state,
  bus_arbitration,
  bus_transfer,
  comm_port,
  interrupt,
  idle,
  halted
};
inline constexpr std::size_t pipeline_cause_count = static_cast<std::size_t>(Cause::wait_state) + 1;

struct CauseRow {
  Cause cause;
  std::string_view name;    ///< key in reports, profiles and traces
  std::string_view letter;  ///< letter and word of the pipeline diagram; empty: the stages show these cycles
  std::string_view meaning;
};
inline constexpr auto cause_rows = std::to_array<CauseRow>({
    {Cause::execute, "execute", "", "an instruction advanced"},
    {Cause::branch, "branch", "", "the pipeline refills after a standard branch, call, return, trap or repeat set-up"},
    {Cause::register_conflict, "register_conflict", "", "address generation waited for a register"},
    {Cause::memory_conflict, "memory_conflict", "", "on-chip port or bus taken by another access of the processor"},
    {Cause::dma_conflict, "dma_conflict", "d DMA", "on-chip port or bus taken by the DMA coprocessor"},
    {Cause::cache_miss, "cache_miss", "", "the instruction cache did not have the word"},
    {Cause::wait_state, "wait_state", "", "wait states of a region"},
    {Cause::bus_arbitration, "bus_arbitration", "b shared bus", "waited for a shared bus"},
    {Cause::bus_transfer, "bus_transfer", "b shared bus", "waited for a shared bus to move the word"},
    {Cause::comm_port, "comm_port", "p port", "waited for a communication port"},
    {Cause::interrupt, "interrupt", "", "interrupt entry"},
    {Cause::idle, "idle", "", "IDLE"},
    {Cause::halted, "halted", "", "held in reset, or stopped by a fault"},
});
inline constexpr std::size_t cause_count = cause_rows.size();
using Causes = std::array<Cycles, cause_count>;

constexpr std::string_view name(Cause cause) { return cause_rows[static_cast<std::size_t>(cause)].name; }

}  // namespace c40
