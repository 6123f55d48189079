#pragma once
/// A block: a recorded sequence of instructions that the exact engine has executed once. It has their handlers in a
/// row, and the cycles and causes from the pipeline model.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "c40/instructions/op.hpp"
#include "c40/memory/memory.hpp"
#include "c40/pipeline/pipeline_table.hpp"
#include "c40/values/types.hpp"

namespace c40 {

/// Cycles of a block by cause: those of the pipeline model.
using Costs = std::array<std::uint16_t, pipeline_cause_count>;

/// Everything on which the recorded timing and the chosen handlers depend.
struct CodeBlockKey {
  static constexpr std::uint32_t set_condition = 1, repeat = 2, cached = 16, frozen = 32;  ///< bits of `mode`
  static constexpr unsigned repeat_single = 2;  ///< the first of two bits of `mode`: the state of RPTS
  Address pc = 0;
  Address repeat_end = 0;  ///< RE if RM is set
  PipelineId pipeline = 0;
  /// SET COND, RM, the state of RPTS, whether the block's words come from the cache, and whether the cache was frozen
  /// then. Also CE and CF at their places in ST, for all blocks: so the blocks that follow have the same CE and CF.
  std::uint32_t mode = 0;
  std::uint32_t hits = 0;  ///< which of the block's words, and of those after it, are in the cache
  static constexpr Address none = ~Address{0};
  /// Where another block was often left because of an access: the base of the area that this access reaches.
  Address left_for = none;
  friend bool operator==(const CodeBlockKey&, const CodeBlockKey&) = default;
  /// They differ at most in address, and in what follows from it: whether the words come from the cache, and from
  /// which of them.
  bool is_elsewhere(const CodeBlockKey& other) const {
    return pipeline == other.pipeline && repeat_end == other.repeat_end &&
           ((mode ^ other.mode) & ~(cached | frozen)) == 0;
  }
};
struct CodeBlockKeyHash {
  std::size_t operator()(const CodeBlockKey& key) const {
    std::uint64_t h = (std::uint64_t{key.pc} << 32 | key.repeat_end) * 0x9E3779B97F4A7C15u;
    h ^= (h >> 29) ^ (std::uint64_t{key.pipeline} << 12 | key.mode) * 0xBF58476D1CE4E5B9u;
    h += std::uint64_t{key.hits ^ ~key.left_for} * 0x94D049BB133111EBu;
    return static_cast<std::size_t>(h ^ h >> 32);
  }
};

/// An access of an instruction in a block through a window, which the board answers each time, or to a linked port,
/// before which the chip stops each time.
struct WindowAccess {
  std::size_t at = 0;  ///< the instruction
  std::uint8_t access = 0;
  const Memory::Area* area = nullptr;
  Cycles start = 0;            ///< since the beginning of the instruction
  bool interlocked = false;    ///< LDII, STII and the like
  std::optional<bool> lock{};  ///< the new state of LOCK, if the access changes it
};

/// What fetching words makes of the cache: numbers of its contents (InstructionCache).
struct CacheStep {
  static constexpr std::uint32_t none = ~0u;  ///< the number of no contents
  std::uint32_t before = none;
  Address begin = 0;  ///< of the words
  std::uint32_t words = 0;
  std::uint32_t after = none;
  bool is(std::uint32_t contents, Address first, std::size_t count) const {
    return before == contents && begin == first && words == count;
  }
};

struct CodeBlock {
  /// Aligned, so that finding an exit takes a shift and no multiplication.
  struct alignas(64) Exit {
    Cycles cycles = 0;
    PipelineId pipeline = 0;
    bool chained = false;  ///< `next` may be kept: only the pc decides which block follows.
    Costs causes{};
    std::uint32_t charged = 0;  ///< Bit n: causes[n] is not 0.
    std::uint64_t count = 0;  ///< runs of the whole block that are not yet added to the chip's causes and instructions
    std::size_t size = 0;     ///< instructions of the block
    CodeBlock* next = nullptr;
    Exit* counted = nullptr;  ///< the next exit whose count is not 0
  };
  CodeBlockKey key;
  std::vector<Op> ops;  ///< one per instruction, then the terminal, unless the last instruction ends the block itself
  std::size_t size = 0;
  // Before instruction i; the last entry is after all instructions, without a branch.
  std::vector<Cycles> start;
  std::vector<Costs> causes;
  std::uint32_t charged = 0;  ///< Bit n: some instruction costs cycles of cause n.
  std::vector<PipelineId> pipelines;
  std::vector<std::uint8_t> delay_slots;
  std::vector<WindowAccess> windows;
  std::array<Exit, 2> exits{};
  Cycles last_start = 0;
  Cycles plain_start = std::numeric_limits<Cycles>::max();  ///< last_start of a plain block; no budget covers any other
  bool repeats = false;                                     ///< ends at RE: the loop hardware decides what follows
  bool self_loop = false;                                   ///< if it follows itself, the state is the same again
  bool only_nop = false;
  bool in_one_go =
      false;  ///< runs from its first instruction to an exit in one go: it does not repeat and has no window access
  bool uses_cache = false;                 ///< fetched while the cache was on
  bool changes_cache = false;              ///< fetched while the cache was on and not frozen
  bool all_hits = false;                   ///< `words` are all in the cache already
  std::uint32_t own_words = 0;             ///< the bits of key.hits that are its own words; 0 without the cache
  std::uint32_t fitted = CacheStep::none;  ///< the contents of the cache that last had the hits of its key
  CacheStep cache_step;                    ///< its last one
  std::vector<Word> words;                 ///< if it uses the cache
  std::uint32_t times_left = 0;            ///< because of an access
  /// A block that begins in this one, with an instruction whose access reaches another area.
  struct Other {
    const Memory::Area* area = nullptr;
    CodeBlock* block = nullptr;
  };
  /// An access that reaches many areas rarely comes back to one.
  std::array<Other, 3> others{};

  const WindowAccess* window(std::size_t instruction) const {
    const auto found = std::ranges::find(windows, instruction, &WindowAccess::at);
    return found != windows.end() ? &*found : nullptr;
  }
  /// Adds the costs of instructions [from, to) to `sum`.
  void add_causes(Causes& sum, std::size_t from, std::size_t to) const {
    add_difference(sum, causes[from], causes[to]);
  }
  /// Subtracts them.
  void subtract_causes(Causes& sum, std::size_t from, std::size_t to) const {
    add_difference(sum, causes[to], causes[from]);
  }

 private:
  void add_difference(Causes& sum, const Costs& from, const Costs& to) const {
    for (std::uint32_t left = charged; left != 0; left &= left - 1) {
      const auto cause = static_cast<std::size_t>(std::countr_zero(left));
      sum[cause] += to[cause] - from[cause];
    }
  }
};

inline void add(Causes& causes, Cause cause, Cycles cycles) { causes[static_cast<std::size_t>(cause)] += cycles; }

}  // namespace c40
