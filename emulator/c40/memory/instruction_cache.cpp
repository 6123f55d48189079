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
    state_.cache.clear();
    ++version_;
    stale_ = false;
  }
  for (std::size_t i = done; i < state_.cache_changes; ++i) state_.cache_change[i - done] = state_.cache_change[i];
  state_.cache_changes -= done;
  for (std::size_t i = state_.cache_changes; i < state_.cache_change.size(); ++i) state_.cache_change[i] = {};
}

void InstructionCache::load(Address pc, Word word, const Memory::Area& area) {
  state_.cache.load(pc, {&word, 1});
  area.mark_code(pc);
  ++version_;
}

bool InstructionCache::has_words_of(CodeBlock& block) const {
  const std::uint32_t hits = state_.cache.hits_from(block.key.pc, static_cast<unsigned>(block.size));
  if (((hits ^ block.key.hits) & block.own_words) != 0) return false;
  block.checked = version_;
  return true;
}

void InstructionCache::fetch_words(const CodeBlock& block, std::size_t from, std::size_t to) {
  const Address begin = block.key.pc + static_cast<Address>(from), end = block.key.pc + static_cast<Address>(to);
  if (block.all_hits) {
    hit(begin);
    if ((begin ^ (end - 1)) >= Cache::segment_words) hit(end - 1);
    return;
  }
  ++version_;
  const std::span words{block.words.data() + from, to - from};
  if (begin % Cache::segment_words + words.size() > Cache::segment_words) return load_two_segments(begin, words);
  state_.cache.load(begin, words);
}

// A block has at most as many words as a segment.
void InstructionCache::load_two_segments(Address begin, std::span<const Word> words) {
  const std::size_t in_first = Cache::segment_words - begin % Cache::segment_words;
  state_.cache.load(begin, words.first(in_first));
  state_.cache.load(begin + static_cast<Address>(in_first), words.subspan(in_first));
}

void InstructionCache::mark_code(Memory& memory) const {
  state_.cache.each_word([&memory](Address pc) {
    if (const Memory::Area* area = memory.find(pc); area != nullptr && area->data != nullptr) area->mark_code(pc);
  });
}

void InstructionCache::was_reset() {
  ++version_;
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
