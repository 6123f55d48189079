#pragma once
/// The instruction cache as the engine uses it: when CE, CF and CC act, how fetches change the cached words, and what
/// is known about these words.
#include <cstddef>
#include <cstdint>
#include <span>

#include "c40/engine/block.hpp"
#include "c40/memory/memory.hpp"
#include "c40/values/state.hpp"

namespace c40 {

class InstructionCache {
 public:
  explicit InstructionCache(State& state) : state_(state) {}

  // As the fetch stage sees CE now.
  bool on() const { return (state_.cache_control & st::CE) != 0; }
  bool frozen() const { return (state_.cache_control & st::CF) != 0; }
  const Word* find(Address pc) const { return state_.cache.find(pc); }

  /// ST and the fetch stage differ.
  bool control_pending() const {
    return state_.cache_changes != 0 || ((state_.core.modes ^ state_.cache_control) & bits) != 0;
  }
  /// An instruction that executed in cycle `executed` may have changed CE or CF, or written CC. At most three
  /// instructions can execute before a fetch: throws std::logic_error for more changes.
  void note_control(Cycles executed) {
    const Word control = state_.core.modes & bits;
    if (control != last_control() || state_.cache_clear) [[unlikely]]
      add_change(executed, control);
  }
  /// The next instruction is fetched in cycle `fetched` or later, after the instructions executed before: CE, CF and CC
  /// act no earlier.
  void settle_control(Cycles fetched);

  /// A fetched word was in the cache.
  void hit(Address pc) { state_.cache.touch(pc); }
  /// A fetched word was not in the cache and is loaded.
  void load(Address pc, Word word, const Memory::Area& area);
  /// The effect on the cache of fetching instructions [from, to) of a block.
  void fetch(const CodeBlock& block, std::size_t from, std::size_t to) {
    if (block.changes_cache && from != to) fetch_some(block, from, to);
  }
  /// The effect of fetching all of them.
  void fetch(const CodeBlock& block) {
    if (block.changes_cache) fetch_some(block, 0, block.size);
  }
  /// The cache holds the same of the block's words as when the block was recorded.
  bool fits(CodeBlock& block) const { return is_unchanged_for(block) || has_words_of(block); }
  /// The block was found by the cache's contents, so it fits.
  void note_fit(CodeBlock& block) const { block.checked = version_; }
  /// Nothing was loaded or removed since the block was last known to fit.
  bool is_unchanged_for(const CodeBlock& block) const { return block.checked == version_; }
  /// Which of 32 words from an address on the cache holds.
  std::uint32_t hits_from(Address pc) const { return state_.cache.hits_from(pc); }

  /// A word of memory has changed.
  void memory_written(Address address) { stale_ |= find(address) != nullptr; }
  /// The cache holds words that differ from memory.
  bool stale() const { return stale_; }
  /// Marks the cached words as code: a write to one of them makes the cache stale.
  void mark_code(Memory& memory) const;

  /// The chip was reset: its state was replaced.
  void was_reset();
  /// The chip was loaded: its state was replaced.
  void was_loaded(const Memory& memory);

 private:
  static constexpr Word bits = st::CE | st::CF;
  Word last_control() const {
    return state_.cache_changes != 0 ? state_.cache_change[state_.cache_changes - 1].control : state_.cache_control;
  }
  void add_change(Cycles executed, Word control);
  bool has_words_of(CodeBlock& block) const;
  void fetch_some(const CodeBlock& block, std::size_t from, std::size_t to) {
    const Address begin = block.key.pc + static_cast<Address>(from), end = block.key.pc + static_cast<Address>(to);
    if (!block.all_hits || !state_.cache.is_latest(begin) || !state_.cache.is_latest(end - 1))
      fetch_words(block, from, to);
  }
  void fetch_words(const CodeBlock& block, std::size_t from, std::size_t to);
  [[gnu::noinline]] void load_two_segments(Address begin, std::span<const Word> words);

  State& state_;
  std::uint64_t version_ = 1;  ///< rises when a word is loaded or removed
  bool stale_ = false;
};

}  // namespace c40
