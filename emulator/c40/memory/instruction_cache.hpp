#pragma once
/// The instruction cache as the engine uses it: when CE, CF and CC act, how fetches change the cached words, and what
/// is known about these words.
///
/// A program comes back to the same contents of the cache again and again. Contents get a number when they are met
/// first, and it is kept which contents a fetch makes of which (CacheStep). So code that runs again changes the number,
/// and neither segments nor words.
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "c40/chip/state.hpp"
#include "c40/engine/block.hpp"
#include "c40/memory/memory.hpp"

namespace c40 {

class InstructionCache {
 public:
  explicit InstructionCache(State& state) : state_(state) {}

  // As the fetch stage sees CE now.
  bool on() const { return (state_.cache_control & st::CE) != 0; }
  Word control() const { return state_.cache_control; }  ///< CE and CF, as the fetch stage sees them now
  bool frozen() const { return (state_.cache_control & st::CF) != 0; }
  const Word* find(Address pc) const { return contents().find(pc); }

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
  void hit(Address pc) {
    if (!contents().is_latest(pc)) load(pc, *find(pc));
  }
  /// A fetched word was not in the cache and is loaded. It is marked as code already.
  void load(Address pc, Word word) { fetch_words(pc, {&word, 1}); }
  /// The effect on the cache of fetching instructions [from, to) of a block.
  [[gnu::noinline]] void fetch(CodeBlock& block, std::size_t from, std::size_t to) {
    if (block.changes_cache)
      block.cache_step = fetch_words(block.key.pc + static_cast<Address>(from), {block.words.data() + from, to - from});
  }
  /// The effect of fetching all of them.
  void fetch(CodeBlock& block) {
    if (!block.changes_cache) return;
    if (block.cache_step.before == number_ && block.cache_step.words == block.size) [[likely]]
      number_ = block.cache_step.after;
    else
      fetch(block, 0, block.size);
  }
  /// The cache holds the same of the block's words as when the block was recorded.
  bool fits(CodeBlock& block) { return block.fitted == number_ || !block.uses_cache || fits_now(block); }
  /// The block was found by the cache's contents, so it fits.
  void note_fit(CodeBlock& block) {
    if (block.uses_cache && number_contents()) block.fitted = number_;
  }
  /// Which of 32 words from an address on the cache holds.
  std::uint32_t hits_from(Address pc) const { return contents().hits_from(pc, frozen()); }
  /// Brings state_.cache up to date.
  void settle() {
    if (number_ != unnumbered) state_.cache = contents();
  }

  /// A word of memory has changed.
  void memory_written(Address address) { stale_ |= find(address) != nullptr; }
  /// The cache holds words that differ from memory.
  bool stale() const { return stale_; }
  /// The blocks are gone, and with them the marks of their words as code. Marks the cached words: a write to one of
  /// them makes the cache stale. A write to another word will not be noticed, so no step is kept.
  void blocks_cleared(Memory& memory);

  /// The chip was reset: its state was replaced.
  void was_reset();
  /// The chip was loaded: its state was replaced.
  void was_loaded(const Memory& memory);

 private:
  static constexpr std::uint32_t unnumbered = 0;
  static constexpr std::size_t most_numbered = 2048, most_steps = 4096;
  static constexpr Word bits = st::CE | st::CF;
  Word last_control() const {
    return state_.cache_changes != 0 ? state_.cache_change[state_.cache_changes - 1].control : state_.cache_control;
  }
  void add_change(Cycles executed, Word control);
  const Cache& contents() const { return number_ != unnumbered ? numbered_[number_ - first_number_] : state_.cache; }
  bool number_contents() { return number_ != unnumbered || give_number(); }
  bool give_number();
  void forget_numbers();
  bool fits_now(CodeBlock& block);
  CacheStep fetch_words(Address begin, std::span<const Word> words);
  void put_words(Address begin, std::span<const Word> words);

  State& state_;
  std::uint32_t number_ = unnumbered;  ///< of the present contents; unnumbered: they are in state_.cache
  std::uint32_t first_number_ = 1;     ///< of numbered_[0]; no number is used again
  std::vector<Cache> numbered_;
  std::unordered_map<std::size_t, std::uint32_t> numbers_;  ///< by hash of the contents
  std::vector<CacheStep> steps_;                            ///< by hash of what is before, and of the words
  Cycles numbers_since_ = 0;
  Cycles no_numbers_until_ = 0;
  bool stale_ = false;
};

}  // namespace c40
