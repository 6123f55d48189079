#pragma once
/// A block: instructions that the exact engine once did one after the other, recorded: their handlers in a row, and the
/// cycles and causes that the pipeline model gave.
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "c40/memory.hpp"
#include "c40/op.hpp"
#include "c40/pipeline_table.hpp"
#include "c40/types.hpp"

namespace c40 {

/// Cycles by cause, of a block: by those causes that the pipeline model knows, which come first.
inline constexpr std::size_t block_cause_count = static_cast<std::size_t>(Cause::wait_state) + 1;
using Costs = std::array<std::uint16_t, block_cause_count>;

/// Everything that the recorded timing and the chosen handlers depend on.
struct CodeBlockKey {
  static constexpr std::uint32_t set_condition = 1, repeat = 2, cached = 16, frozen = 32;  ///< of `mode`
  static constexpr unsigned repeat_single = 2;  ///< the first of two bits of `mode`: the state of RPTS
  Address pc = 0;
  Address repeat_end = 0;  ///< RE while RM is set
  PipelineId pipeline = 0;
  std::uint32_t mode = 0;  ///< SET COND, RM, the state of RPTS, whether the cache is on, and frozen
  std::uint32_t hits = 0;  ///< which of its words and those after it the cache has
  friend bool operator==(const CodeBlockKey&, const CodeBlockKey&) = default;
};
struct CodeBlockKeyHash {
  std::size_t operator()(const CodeBlockKey& key) const {
    std::uint64_t h = (std::uint64_t{key.pc} << 32 | key.repeat_end) * 0x9E3779B97F4A7C15u;
    h ^= (h >> 29) ^ (std::uint64_t{key.pipeline} << 6 | key.mode) * 0xBF58476D1CE4E5B9u;
    h += std::uint64_t{key.hits} * 0x94D049BB133111EBu;
    return static_cast<std::size_t>(h ^ h >> 32);
  }
};

/// An access of a block's instruction that goes through a window: the board is asked each time.
struct WindowAccess {
  std::size_t at = 0;  ///< the instruction
  std::uint8_t access = 0;
  const Memory::Area* area = nullptr;
  Cycles start = 0;            ///< since the instruction began
  bool interlocked = false;    ///< LDII, STII and the like
  std::optional<bool> lock{};  ///< what it makes of LOCK
};

struct CodeBlock {
  struct Exit {
    Cycles cycles = 0;
    PipelineId pipeline = 0;
    bool chained = false;  ///< `next` may be kept: nothing but the pc decides which block follows.
    Costs causes{};
    std::uint64_t count = 0;  ///< runs of the whole block not yet in the chip's causes and instructions
    std::size_t size = 0;     ///< instructions of the block
    CodeBlock* next = nullptr;
  };
  CodeBlockKey key;
  std::vector<Op> ops;  ///< one per instruction, then the terminal if the last instruction is not one itself
  std::size_t size = 0;
  // Before instruction i; the last entry is after all, straight on.
  std::vector<Cycles> start;
  std::vector<Costs> causes;
  std::vector<PipelineId> pipelines;
  std::vector<std::uint8_t> delay_slots;
  std::vector<WindowAccess> windows;
  std::array<Exit, 2> exits{};
  Cycles last_start = 0;
  bool repeats = false;    ///< ends at RE: the loop hardware decides
  bool self_loop = false;  ///< following itself, it is in the same state again
  bool only_nop = false;
  bool plain = false;         ///< neither repeats nor uses the cache
  bool in_one_go = false;     ///< from its first instruction to an exit: it does not repeat, or looks through windows
  bool uses_cache = false;    ///< fetched while the cache was on
  bool all_hits = false;      ///< `words` need not come into the cache
  std::uint64_t checked = 0;  ///< the version of the cache in which its hits were last seen to be those of its key
  std::vector<Word> words;    ///< if it uses the cache

  const WindowAccess* window(std::size_t instruction) const {
    const auto found = std::ranges::find(windows, instruction, &WindowAccess::at);
    return found != windows.end() ? &*found : nullptr;
  }
};

inline void add(Causes& causes, Cause cause, Cycles cycles) { causes[static_cast<std::size_t>(cause)] += cycles; }

inline void add_difference(Causes& causes, const Costs& to, const Costs& from) {
  for (std::size_t i = 0; i < block_cause_count; ++i) causes[i] += to[i] - from[i];
}

}  // namespace c40
