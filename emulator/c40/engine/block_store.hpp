#pragma once
/// The blocks of a chip by their keys, and the number of runs of each since the last settle().
#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "c40/engine/block.hpp"
#include "c40/memory/memory.hpp"

namespace c40 {

class BlockStore {
 public:
  /// Null if there is no such block.
  CodeBlock* find(const CodeBlockKey& key) const;
  bool full() const;
  /// Where an exit leads to several blocks, as at the end of a subroutine: one that begins at `pc` and has a key as
  /// `like` otherwise. Null if none was found there of late.
  CodeBlock* recent(Address pc, const CodeBlockKey& like) const {
    CodeBlock* const block = recent_[pc % recent_.size()];
    return block != nullptr && block->key.pc == pc && block->key.is_elsewhere(like) ? block : nullptr;
  }
  void note_recent(CodeBlock& block) { recent_[block.key.pc % recent_.size()] = &block; }
  /// A recording from `pc` on is cut by the end of a run. Where this happens each time, a short block is better than
  /// none; elsewhere the next recording is a longer one.
  bool is_cut_again_and_again(Address pc) {
    Recordings& cut = cuts_[pc % cuts_.size()];
    if (cut.pc != pc) cut = {pc, 0};
    return ++cut.times > most_cuts;
  }
  /// A recording from `pc` on came to nothing: no block may end there, or a delay slot waited for a word.
  void gave_up(Address pc) {
    Recordings& recordings = given_up_[pc % given_up_.size()];
    if (recordings.pc != pc) recordings = {pc, 0};
    ++recordings.times;
  }
  /// Where recordings have come to nothing again and again, one arrival in 64 is recorded.
  bool may_record(Address pc) {
    Recordings& recordings = given_up_[pc % given_up_.size()];
    return recordings.pc != pc || recordings.times < most_given_up || ++recordings.times % 64 == 0;
  }
  /// Adds a block and marks its words as code in `memory`.
  void add(std::unique_ptr<CodeBlock> block, Memory& memory);
  /// Deletes all blocks and their marks in memory. All counts must be settled before.
  void clear(Memory& memory);

  /// Counts `times` runs of a whole block that end at this exit; settle() adds them up.
  [[gnu::always_inline]] void count(CodeBlock::Exit& exit, std::uint64_t times) {
    if (exit.count == 0 && times != 0) [[unlikely]] {
      exit.counted = counted_;
      counted_ = &exit;
    }
    exit.count += times;
  }
  /// Adds the counts to the chip's causes and instructions.
  void settle(Causes& causes, std::uint64_t& instructions);

 private:
  static constexpr unsigned most_cuts = 8, most_given_up = 8;
  struct Recordings {
    Address pc = 0;
    unsigned times = 0;
  };
  std::array<Recordings, 256> cuts_{}, given_up_{};  ///< by address
  std::vector<std::unique_ptr<CodeBlock>> blocks_;
  std::unordered_map<CodeBlockKey, CodeBlock*, CodeBlockKeyHash> by_key_;
  std::array<CodeBlock*, 256> recent_{};  ///< by address
  CodeBlock::Exit* counted_ = nullptr;    ///< the first of the exits whose count is not 0
};

/// Addresses with which no block can begin: the exact engine executes these instructions each time, without a search
/// for a block.
class ExactAddresses {
 public:
  bool contains(Address pc) const {
    return entries_[pc % entries_.size()].known && entries_[pc % entries_.size()].pc == pc;
  }
  /// \param only_outside the instruction's access went outside the chip or to a register. Once such an access stays in
  /// memory, the address is removed (stayed_inside).
  void add(Address pc, bool only_outside) { entries_[pc % entries_.size()] = {pc, true, only_outside}; }
  void remove(Address pc) { entries_[pc % entries_.size()] = {}; }
  /// The instruction was executed, and a block could have done it.
  void stayed_inside(Address pc) {
    if (contains(pc) && entries_[pc % entries_.size()].only_outside) remove(pc);
  }
  void clear() { entries_ = {}; }

 private:
  struct Entry {
    Address pc = 0;
    bool known = false, only_outside = false;
  };
  std::array<Entry, 1024> entries_{};
};

/// The end of the last run of blocks, if the next instruction can continue from it. At most one of the three kinds at a
/// time.
class Continuation {
 public:
  void clear() { kind_ = Kind::none; }
  /// A block ended at this exit, and nothing has happened since.
  void after(CodeBlock::Exit& exit) {
    kind_ = Kind::exit;
    exit_ = &exit;
  }
  /// The budget ended before instruction `at` of the block, or the exact engine has returned to this instruction.
  void inside(CodeBlock& block, std::size_t at) {
    kind_ = Kind::inside;
    block_ = &block;
    at_ = at;
  }
  /// The instruction at PC belongs to this block, but the exact engine must execute it, or another block that begins
  /// there, if the block is `often` left there.
  void missed(CodeBlock& block, bool often) {
    kind_ = Kind::missed;
    block_ = &block;
    often_ = often;
  }
  bool is_inside() const { return kind_ == Kind::inside; }
  bool is_missed() const { return kind_ == Kind::missed; }
  /// The block that is often left here, else null. Clears nothing.
  CodeBlock* often_missed() const { return kind_ == Kind::missed && often_ ? block_ : nullptr; }
  /// The instruction of take_inside()'s block with which to continue.
  std::size_t at() const { return at_; }
  // Each returns null if the continuation has another kind; else it returns the object and clears the continuation.
  CodeBlock::Exit* take_exit() { return take(Kind::exit) ? exit_ : nullptr; }
  CodeBlock* take_inside() { return take(Kind::inside) ? block_ : nullptr; }
  CodeBlock* take_missed() { return take(Kind::missed) ? block_ : nullptr; }

 private:
  enum class Kind : std::uint8_t { none, exit, inside, missed };
  bool take(Kind kind) {
    if (kind_ != kind) return false;
    kind_ = Kind::none;
    return true;
  }
  Kind kind_ = Kind::none;
  CodeBlock::Exit* exit_ = nullptr;
  CodeBlock* block_ = nullptr;
  std::size_t at_ = 0;
  bool often_ = false;
};

}  // namespace c40
