#include "c40/memory/instruction_cache.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>

namespace c40 {

void InstructionCache::add_change(Cycles executed, Word control) {
  if (state_.cache_changes == state_.cache_change.size())
    throw std::logic_error("more changes of the cache's control than instructions in the pipeline");
  state_.cache_change[state_.cache_changes++] = {executed, control, std::exchange(state_.cache_clear, false)};
  state_.core.attention = true;
}

void InstructionCache::settle_control(Cycles fetched) {
  if (state_.cache_changes == 0)
    note_control(std::numeric_limits<Cycles>::min());  // the change was in a block, long before
  std::size_t done = 0;
  for (; done < state_.cache_changes && state_.cache_change[done].executed < fetched; ++done) {
    const State::CacheChange& change = state_.cache_change[done];
    state_.cache_control = change.control;
    if (!change.clear) continue;
    settle();
    number_ = unnumbered;
    state_.cache.clear();
    stale_ = false;
  }
  for (std::size_t i = done; i < state_.cache_changes; ++i) state_.cache_change[i - done] = state_.cache_change[i];
  state_.cache_changes -= done;
  for (std::size_t i = state_.cache_changes; i < state_.cache_change.size(); ++i) state_.cache_change[i] = {};
}

// Gives the present contents a number. False: there are no numbers at present.
bool InstructionCache::give_number() {
  if (state_.cycle < no_numbers_until_) return false;
  const Cache& now = state_.cache;
  const std::size_t hash = now.hash();
  const auto found = numbers_.find(hash);
  if (found != numbers_.end() && numbered_[found->second - first_number_] == now) {
    number_ = found->second;
    return true;
  }
  if (numbered_.size() == most_numbered) forget_numbers();
  number_ = first_number_ + static_cast<std::uint32_t>(numbered_.size());
  numbered_.push_back(now);
  numbers_[hash] = number_;
  return true;
}

// Where nearly every block makes contents that were never there before, numbers cost more than they save.
void InstructionCache::forget_numbers() {
  constexpr Cycles few = Cycles{most_numbered} * 256, pause = 64 * few;
  if (state_.cycle - numbers_since_ < few) no_numbers_until_ = state_.cycle + pause;
  numbers_since_ = state_.cycle;
  first_number_ += static_cast<std::uint32_t>(numbered_.size());
  numbered_.clear();
  numbers_.clear();
}

bool InstructionCache::fits_now(CodeBlock& block) {
  const bool frozen = (block.key.mode & CodeBlockKey::frozen) != 0;
  const std::uint32_t hits = contents().hits_from(block.key.pc, frozen, static_cast<unsigned>(block.size));
  if (((hits ^ block.key.hits) & block.own_words) != 0) return false;
  note_fit(block);
  return true;
}

// Fetches words in order, not more than a segment has. Gives the step that this was.
CacheStep InstructionCache::fetch_words(Address begin, std::span<const Word> words) {
  if (!number_contents()) {
    put_words(begin, words);
    return {};
  }
  if (steps_.empty()) steps_.resize(most_steps);
  const std::uint32_t hash =
      (number_ * 0x9E3779B1u ^ begin ^ static_cast<std::uint32_t>(words.size()) << 7) * 0x85EBCA77u;
  CacheStep& step = steps_[hash >> (32 - std::bit_width(most_steps - 1))];
  if (!step.is(number_, begin, words.size())) {
    const std::uint32_t before = number_;
    put_words(begin, words);
    if (!number_contents()) return {};
    step = {before, begin, static_cast<std::uint32_t>(words.size()), number_};
  }
  number_ = step.after;
  return step;
}

void InstructionCache::put_words(Address begin, std::span<const Word> words) {
  const std::size_t in_first = std::min<std::size_t>(words.size(), Cache::segment_words - begin % Cache::segment_words);
  settle();
  number_ = unnumbered;
  state_.cache.load(begin, words.first(in_first));
  if (in_first != words.size()) state_.cache.load(begin + static_cast<Address>(in_first), words.subspan(in_first));
}

void InstructionCache::blocks_cleared(Memory& memory) {
  steps_.clear();
  contents().each_word([&memory](Address pc) {
    if (const Memory::Area* area = memory.find(pc); area != nullptr && area->data != nullptr) area->mark_code(pc);
  });
}

void InstructionCache::was_reset() {
  number_ = unnumbered;
  numbers_since_ = no_numbers_until_ = 0;
  stale_ = false;
}

void InstructionCache::was_loaded(const Memory& memory) {
  was_reset();
  state_.cache.each_word([&](Address address) {
    const Memory::Area* area = memory.find(address);
    stale_ |= area != nullptr && area->data != nullptr && area->data[address - area->base] != *find(address);
  });
}

}  // namespace c40
