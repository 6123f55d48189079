#include "c40/memory/instruction_cache.hpp"

#include <algorithm>
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
    changed().clear();
    stale_ = false;
  }
  for (std::size_t i = done; i < state_.cache_changes; ++i) state_.cache_change[i - done] = state_.cache_change[i];
  state_.cache_changes -= done;
  for (std::size_t i = state_.cache_changes; i < state_.cache_change.size(); ++i) state_.cache_change[i] = {};
}

void InstructionCache::load(Address pc, Word word, const Memory::Area& area) {
  changed().load(pc, {&word, 1});
  area.mark_code(pc);
}

// Gives the present contents a number. False: there are no numbers at present.
bool InstructionCache::number_contents() {
  if (number_ != unnumbered) return true;
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
  if (!block.uses_cache) return true;
  const bool numbered = number_contents();
  for (CacheStep& step : block.cache_steps)
    if (step.is(number_, 0, block.size)) {
      std::swap(step, block.cache_steps[0]);  // fetch() comes next
      return true;
    }
  const std::uint32_t hits = contents().hits_from(block.key.pc, static_cast<unsigned>(block.size));
  if (((hits ^ block.key.hits) & block.own_words) != 0) return false;
  if (numbered) block.fitted = number_;
  return true;
}

void InstructionCache::fetch_by_other_step(CodeBlock& block, std::size_t from, std::size_t to) {
  if (!number_contents()) return fetch_words(block, from, to);
  auto& steps = block.cache_steps;
  for (CacheStep& step : steps)
    if (step.is(number_, from, to)) {
      std::swap(step, steps[0]);
      number_ = steps[0].after;
      return;
    }
  const std::uint32_t before = number_;
  fetch_words(block, from, to);
  if (!number_contents()) return;
  std::shift_right(steps.begin(), steps.end(), 1);
  steps[0] = {before, static_cast<std::uint16_t>(from), static_cast<std::uint16_t>(to), number_};
}

// A block has at most as many words as a segment, so its words are in two segments at most.
void InstructionCache::fetch_words(const CodeBlock& block, std::size_t from, std::size_t to) {
  const Address begin = block.key.pc + static_cast<Address>(from);
  const std::span words{block.words.data() + from, to - from};
  const std::size_t in_first = std::min<std::size_t>(words.size(), Cache::segment_words - begin % Cache::segment_words);
  Cache& cache = changed();
  cache.load(begin, words.first(in_first));
  if (in_first != words.size()) cache.load(begin + static_cast<Address>(in_first), words.subspan(in_first));
}

void InstructionCache::mark_code(Memory& memory) const {
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
