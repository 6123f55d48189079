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
  Block* find(const BlockKey& key) const;
  bool full() const;
  /// Marks its words as code in `memory`.
  void add(std::unique_ptr<Block> block, Memory& memory);
  /// Throws all away, and takes their marks off the memory. Nothing may be left to settle.
  void clear(Memory& memory);

  /// `times` runs of a whole block by one exit: added up when they are asked for.
  void count(Block::Exit& exit, std::uint64_t times) {
    if (exit.count == 0 && times != 0) counted_.push_back(&exit);
    exit.count += times;
  }
  /// Adds what was counted.
  void settle(Causes& causes, std::uint64_t& instructions);

 private:
  std::vector<std::unique_ptr<Block>> blocks_;
  std::unordered_map<BlockKey, Block*, BlockKeyHash> by_key_;
  std::vector<Block::Exit*> counted_;  ///< exits whose count is not 0
};

/// Instructions that no block can begin with: the exact engine does them each time, and no block is looked for.
class ExactSites {
 public:
  bool contains(Address pc) const { return sites_[pc % sites_.size()].known && sites_[pc % sites_.size()].pc == pc; }
  /// \param only_outside because of an access to a register or the like: as long as it makes one
  void add(Address pc, bool only_outside) { sites_[pc % sites_.size()] = {pc, true, only_outside}; }
  void remove(Address pc) { sites_[pc % sites_.size()] = {}; }
  /// It was executed, and a block could have done it.
  void stayed_inside(Address pc) {
    if (contains(pc) && sites_[pc % sites_.size()].only_outside) remove(pc);
  }
  void clear() { sites_ = {}; }

 private:
  struct Site {
    Address pc = 0;
    bool known = false, only_outside = false;
  };
  std::array<Site, 1024> sites_{};
};

/// Where the last run of blocks ended, as far as the next instruction can go on from there. At most one way at a time.
class Continuation {
 public:
  void clear() { kind_ = Kind::none; }
  /// A block was left by this exit, and nothing has happened since.
  void after(Block::Exit& exit) {
    kind_ = Kind::exit;
    exit_ = &exit;
  }
  /// The budget ended before instruction `at` of the block, or the exact engine has come back to there.
  void inside(Block& block, std::size_t at) {
    kind_ = Kind::inside;
    block_ = &block;
    at_ = at;
  }
  /// The instruction at PC belongs to this block, which cannot do it: the exact engine must.
  void missed(Block& block) {
    kind_ = Kind::missed;
    block_ = &block;
  }
  bool is_inside() const { return kind_ == Kind::inside; }
  bool is_missed() const { return kind_ == Kind::missed; }
  /// Instruction at which to go on in take_inside()'s block.
  std::size_t at() const { return at_; }
  // Each is null where it is not so; else it clears.
  Block::Exit* take_exit() { return take(Kind::exit) ? exit_ : nullptr; }
  Block* take_inside() { return take(Kind::inside) ? block_ : nullptr; }
  Block* take_missed() { return take(Kind::missed) ? block_ : nullptr; }

 private:
  enum class Kind : std::uint8_t { none, exit, inside, missed };
  bool take(Kind kind) {
    if (kind_ != kind) return false;
    kind_ = Kind::none;
    return true;
  }
  Kind kind_ = Kind::none;
  Block::Exit* exit_ = nullptr;
  Block* block_ = nullptr;
  std::size_t at_ = 0;
};

}  // namespace c40
