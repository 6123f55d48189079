#pragma once
/// What the exact engine keeps of code from one execution to the next: where instructions are being fetched, and what
/// it met at each address; and one instruction on its way through.
#include <array>
#include <optional>
#include <vector>

#include "c40/bind.hpp"
#include "c40/memory.hpp"
#include "c40/pipeline_table.hpp"

namespace c40 {

/// Where instructions are being fetched: as far around as all fetches are alike.
struct CodeArea {
  const Memory::Area* area = nullptr;
  Memory::AccessInfo met;
  bool cacheable = false;
  const Word* words = nullptr;   ///< from met.base on
  std::uint64_t fetch_bits = 0;  ///< packed

  CodeArea() = default;
  /// \param found memory with contents, in which `pc` lies
  CodeArea(const Memory& memory, const Memory::Area& found, Address pc);
  bool contains(Address pc) const { return pc - met.base < met.words; }
  Word word(Address pc) const { return words[pc - met.base]; }
};

/// An instruction as the exact engine last met it at an address. Its windows and the accesses through them stay as long
/// as they hold for every way in which it can be executed.
struct DecodedSlot {
  bool known = false, set_condition = false, keeps_windows = false;
  bool quick = false;  ///< nothing but its accesses, the pipeline and the PC needs attention
  bool stale = false;  ///< the windows hold for the last execution only
  BoundInstruction bound;
  std::array<Op, 2> ops{};  ///< it, and what stops after it
  Demand demand;
  std::array<const Memory::Area*, 2> area{};  ///< that each access was last in, where all of it is accessed alike
  std::uint64_t data_bits = 0;                ///< its data accesses, packed
  Transition transition;                      ///< the last one

  /// It is this instruction, bound.
  bool is(Word word, bool with_set_condition) const {
    return known && bound.word == word && set_condition == with_set_condition;
  }
  void bind_to(const BoundInstruction& instruction, bool with_set_condition);
  void forget() { known = quick = false; }
  void forget_windows();
};

/// Sites, direct mapped by address.
class DecodedSlotTable {
 public:
  DecodedSlotTable() : decoded_slots_(count) {}
  DecodedSlot& operator[](Address pc) { return decoded_slots_[pc % count]; }
  /// What is known of memory does not hold any more.
  void forget();
  /// Numbers of pipeline states are given out anew.
  void forget_transitions();

 private:
  static constexpr std::size_t count = 1024;
  std::vector<DecodedSlot> decoded_slots_;
};

/// What an interlocked instruction makes of LOCK once its access is through; nothing: it leaves it as it is.
constexpr std::optional<bool> lock_after(isa::Operation operation) {
  using enum isa::Operation;
  if (operation == ldii || operation == ldfi) return true;
  if (operation == stii || operation == stfi) return false;
  return {};
}

/// One instruction on its way through the exact engine.
struct Step {
  DecodedSlot* decoded = nullptr;
  Access fetch;
  Word word = 0;
  bool fetched = true;
  bool from_cache = false, missed = false;  ///< the instruction cache: hit, miss
  bool frozen = false;                      ///< it changes nothing
  bool plain = true;                        ///< data in RAM whose wait states never change
  bool repeatable = true;                   ///< plain, or one access through a window: a block can do it again
  std::uint8_t windows = 0;                 ///< a bit for each access through a window
  bool paged = false;                       ///< the engine's pages_ are what the page pins show afterwards
  bool locks = false;                       ///< interlocked, and leaves the chip
  bool taken = false;
  std::uint8_t register_writes = 0;        ///< a bit for each access
  std::array<Address, 2> address{};        ///< of each data access that was looked up
  std::array<Cycles, 2> register_cycle{};  ///< when the access to a register takes place
  const StepTiming* timing = nullptr;

  /// What it asks of the pipeline, but for the cost of a branch.
  Demand demand() const {
    Demand out = decoded->demand;
    out.fetch = fetch;
    out.fetched = fetched;
    out.fetch_missed = missed;
    return out;
  }
};

}  // namespace c40
