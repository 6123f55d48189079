#pragma once
/// The blocks of a chip, by their keys, and how often each was run since somebody last asked.
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "c40/block.hpp"
#include "c40/memory.hpp"

namespace c40 {

class BlockStore {
 public:
  /// Null if there is none.
  CodeBlock* find(const CodeBlockKey& key) const;
  bool full() const;
  /// Marks its words as code in `memory`.
  void add(std::unique_ptr<CodeBlock> block, Memory& memory);
  /// Throws all away, and takes their marks off the memory. Nothing may be left to settle.
  void clear(Memory& memory);

  /// `times` runs of a whole block by one exit: added up when they are asked for.
  void count(CodeBlock::Exit& exit, std::uint64_t times) {
    if (exit.count == 0 && times != 0) counted_.push_back(&exit);
    exit.count += times;
  }
  /// Adds what was counted.
  void settle(Causes& causes, std::uint64_t& instructions);

 private:
  std::vector<std::unique_ptr<CodeBlock>> blocks_;
  std::unordered_map<CodeBlockKey, CodeBlock*, CodeBlockKeyHash> by_key_;
  std::vector<CodeBlock::Exit*> counted_;  ///< exits whose count is not 0
};

/// Instructions that no block can begin with: the exact engine does them each time, and no block is looked for.
class ExactAddresses {
 public:
  bool contains(Address pc) const {
    return entries_[pc % entries_.size()].known && entries_[pc % entries_.size()].pc == pc;
  }
  /// \param only_outside the instruction left the chip by its access, to a register for example. Once the access stays
  ///   inside, the address is forgotten (stayed_inside).
  void add(Address pc, bool only_outside) { entries_[pc % entries_.size()] = {pc, true, only_outside}; }
  void remove(Address pc) { entries_[pc % entries_.size()] = {}; }
  /// It was executed, and a block could have done it.
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

/// Where the last run of blocks ended, as far as the next instruction can go on from there. At most one way at a time.
class Continuation {
 public:
  void clear() { kind_ = Kind::none; }
  /// A block was left by this exit, and nothing has happened since.
  void after(CodeBlock::Exit& exit) {
    kind_ = Kind::exit;
    exit_ = &exit;
  }
  /// The budget ended before instruction `at` of the block, or the exact engine has come back to there.
  void inside(CodeBlock& block, std::size_t at) {
    kind_ = Kind::inside;
    block_ = &block;
    at_ = at;
  }
  /// The instruction at PC belongs to this block, which cannot do it: the exact engine must.
  void missed(CodeBlock& block) {
    kind_ = Kind::missed;
    block_ = &block;
  }
  bool is_inside() const { return kind_ == Kind::inside; }
  bool is_missed() const { return kind_ == Kind::missed; }
  /// Instruction at which to go on in take_inside()'s block.
  std::size_t at() const { return at_; }
  // Each is null where it is not so; else it clears.
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
};

}  // namespace c40
