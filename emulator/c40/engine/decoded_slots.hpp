#pragma once
/// What the exact engine keeps of code between executions: the area of the present fetches, and for each address the
/// decoded instruction; and one instruction during its execution.
#include <array>
#include <optional>
#include <vector>

#include "c40/instructions/bind.hpp"
#include "c40/memory/memory.hpp"
#include "c40/pipeline/pipeline_table.hpp"

namespace c40 {

/// The area of the present fetches: as far as all fetches around it are alike.
struct CodeArea {
  const Memory::Area* area = nullptr;
  Memory::AccessInfo met;
  bool cacheable = false;
  const Word* words = nullptr;   ///< from met.base on
  std::uint64_t fetch_bits = 0;  ///< packed
  Word unpaged_words = 0;        ///< met.words, or 0

  CodeArea() = default;
  /// \param found memory with contents that contains `pc`
  CodeArea(const Memory& memory, const Memory::Area& found, Address pc);
  bool contains(Address pc) const { return pc - met.base < met.words; }
  /// Contains, and the cost of the fetch does not depend on the page of the access before.
  bool contains_unpaged(Address pc) const { return pc - met.base < unpaged_words; }
  Word word(Address pc) const { return words[pc - met.base]; }
};

/// A decoded instruction with what the exact engine found at its last execution. Its windows and their accesses are
/// kept as long as they hold for every way in which the instruction can be executed.
struct DecodedSlot {
  bool known = false, set_condition = false, keeps_windows = false;
  bool quick = false;                ///< only its accesses, the pipeline and the PC need attention
  bool stale = false;                ///< the windows hold for the last execution only
  std::uint64_t quick_key = no_key;  ///< if it is quick and not stale: key() of its word
  BoundInstruction bound;
  std::array<Op, 2> ops{};  ///< the instruction, and the op that ends the run after it
  Demand demand;
  std::array<const Memory::Area*, 2>
      area{};                   ///< the area of each access's last place, if all of the area is accessed alike
  std::uint64_t data_bits = 0;  ///< its data accesses, packed
  /// The last transition of the pipeline, with the fetch (packed) and the exit of the instruction. Exit::cut, which no
  /// single instruction gives: nothing is known.
  Transition transition;
  std::uint64_t fetch_bits = 0;
  Exit exit = Exit::cut;

  static constexpr std::uint64_t no_key = ~std::uint64_t{0};
  /// The word and the bit of ST on which its binding depends.
  static std::uint64_t key(Word word, Word modes) { return word | std::uint64_t{modes & st::SETCOND} << 32; }

  /// Whether the slot holds this instruction, bound.
  bool is(Word word, bool with_set_condition) const {
    return known && bound.word == word && set_condition == with_set_condition;
  }
  void bind_to(const BoundInstruction& instruction, bool with_set_condition);
  void forget() {
    known = quick = false;
    quick_key = no_key;
  }
  void forget_windows();
  void forget_transition() { exit = Exit::cut; }
  /// The windows hold for the last execution only.
  void make_stale() {
    stale = true;
    quick_key = no_key;
  }
};

/// Decoded slots, direct mapped by address. The table begins small, so that a chip is made quickly, and grows as soon
/// as two instructions want one slot.
class DecodedSlotTable {
 public:
  DecodedSlotTable() { make(first); }
  DecodedSlot& operator[](Address pc) { return decoded_slots_[pc & mask_]; }
  /// The slot for an instruction that is not in the table yet. References from before become invalid.
  DecodedSlot& slot_for_new(Address pc);
  /// Drops all knowledge about memory.
  void forget();
  /// Drops all transitions: pipeline states get new numbers.
  void forget_transitions();

 private:
  static constexpr Address first = 64, most = 1024;
  void make(Address count);

  std::vector<DecodedSlot> decoded_slots_;
  Address mask_ = 0;  ///< their number - 1
};

/// The state of LOCK after an interlocked instruction's access; nothing: unchanged.
constexpr std::optional<bool> lock_after(isa::Operation operation) {
  using enum isa::Operation;
  if (operation == ldii || operation == ldfi) return true;
  if (operation == stii || operation == stfi) return false;
  return {};
}

/// One instruction during its execution by the exact engine.
struct Step {
  DecodedSlot* decoded = nullptr;
  Access fetch;
  Word word = 0;
  bool fetched = true;
  bool from_cache = false, missed = false;  ///< the instruction cache: hit, miss
  bool frozen = false;                      ///< it does not change
  bool plain = true;                        ///< all data is in RAM whose wait states never change
  bool repeatable = true;                   ///< plain, or one access through a window: a block can repeat it
  std::uint8_t windows = 0;                 ///< a bit for each access through a window
  bool paged = false;  ///< the engine's pages_ are the state of the page pins after the instruction
  bool locks = false;  ///< interlocked, with an access outside the chip
  bool taken = false;
  std::uint8_t register_writes = 0;        ///< a bit for each access
  std::array<Address, 2> address{};        ///< of each data access that was resolved
  std::array<Cycles, 2> register_cycle{};  ///< when the access to a register takes place
  const StepTiming* timing = nullptr;

  /// The instruction's demand on the pipeline, without the cost of a branch.
  Demand demand() const {
    Demand out = decoded->demand;
    out.fetch = fetch;
    out.fetched = fetched;
    out.fetch_missed = missed;
    return out;
  }
};

}  // namespace c40
