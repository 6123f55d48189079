#include "c40/engine/block_store.hpp"

#include <bit>
#include <utility>

namespace c40 {
namespace {

constexpr std::size_t most_blocks = 20000;

}  // namespace

CodeBlock* BlockStore::find(const CodeBlockKey& key) const {
  const auto found = by_key_.find(key);
  return found != by_key_.end() ? found->second : nullptr;
}

bool BlockStore::full() const { return blocks_.size() >= most_blocks; }

void BlockStore::add(std::unique_ptr<CodeBlock> block, Memory& memory) {
  for (std::size_t i = 0; i < block->size; ++i) {
    const Address pc = block->key.pc + static_cast<Address>(i);
    memory.find(pc)->mark_code(pc);
  }
  by_key_.emplace(block->key, block.get());
  cuts_[block->key.pc % cuts_.size()] = {};
  blocks_.push_back(std::move(block));
}

void BlockStore::clear(Memory& memory) {
  for (const auto& block : blocks_)
    for (std::size_t i = 0; i < block->size; ++i) {
      const Address pc = block->key.pc + static_cast<Address>(i);
      if (const Memory::Area* area = memory.find(pc)) area->unmark_code(pc);
    }
  by_key_.clear();
  recent_ = {};
  blocks_.clear();
}

void BlockStore::settle(Causes& causes, std::uint64_t& instructions) {
  for (CodeBlock::Exit* exit = counted_; exit != nullptr; exit = exit->counted) {
    for (std::uint32_t left = exit->charged; left != 0; left &= left - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(left));
      causes[i] += static_cast<Cycles>(exit->count) * exit->causes[i];
    }
    instructions += exit->count * exit->size;
    exit->count = 0;
  }
  counted_ = nullptr;
}

}  // namespace c40
