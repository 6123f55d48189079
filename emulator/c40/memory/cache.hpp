#pragma once
/// The instruction cache (c40-hardware.md 6): 4 segments of 32 words, fully associative, least recently used replaced
/// first, one word loaded per miss. The cache holds copies of the words: after a change in memory, the old code still
/// runs until CC clears the cache.
///
/// Inaccuracies: the fetches of the wrong path behind a branch are not modelled, so they load nothing.
#include <emmintrin.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "c40/values/types.hpp"

namespace state {
class Visitor;
}

namespace c40 {

class Cache {
 public:
  static constexpr unsigned segment_count = 4, segment_words = 32;

  /// The cached word at an address, or null.
  const Word* find(Address address) const {
    const unsigned s = segment_of(address);
    return s != segment_count && (present_[s] >> (address & 31) & 1u) != 0 ? &words_[s][address & 31] : nullptr;
  }

  /// For each of the words from an address on, bit 0 first: whether fetching them in order gives a hit. Of the other
  /// words, bits may be set or not.
  /// \param frozen a missing word replaces nothing
  std::uint32_t hits_from(Address address, bool frozen, unsigned words = segment_words) const {
    const unsigned first = segment_of(address), shift = address % segment_words;
    std::uint32_t hits = first != segment_count ? present_[first] >> shift : 0;
    if (shift + words <= segment_words) return hits;
    const unsigned second = segment_of(address + segment_words);
    const bool replaced = !frozen && first == segment_count && second == order_[segment_count - 1];
    if (second != segment_count && !replaced) hits |= present_[second] << (segment_words - shift);
    return hits;
  }

  /// The word's segment is the most recently used one.
  bool is_latest(Address address) const { return start_[order_[0]] == address >> 5; }
  /// A hit: the segment becomes the most recently used one.
  void touch(Address address) {
    if (!is_latest(address)) move_to_front(segment_of(address));
  }

  /// Fetches words of one segment, at least one, in order: missing words are loaded.
  void load(Address address, std::span<const Word> words) {
    unsigned s = segment_of(address);
    if (s == segment_count) {
      s = order_[segment_count - 1];
      present_[s] = 0;
      words_[s] = {};
      start_[s] = address >> 5;
    }
    const std::size_t first = address % segment_words;
    present_[s] |= (~0u >> (segment_words - words.size())) << first;
    if (order_[0] != s) move_to_front(s);
    std::copy(words.begin(), words.end(), words_[s].begin() + first);
  }

  /// CC: clears all P flags; segment addresses and their order stay.
  void clear() { present_ = {}, words_ = {}; }

  /// Calls visit(address) for each word in the cache, those of the most recently used segment first.
  template <class Visit>
  void each_word(Visit&& visit) const {
    for (const unsigned s : order_)
      for (Word rest = present_[s]; rest != 0; rest &= rest - 1)
        visit(start_[s] << 5 | static_cast<Address>(std::countr_zero(rest)));
  }

  /// Of what a program's path makes different; the words follow from the addresses unless memory has changed.
  std::size_t hash() const {
    std::uint64_t h = 0;
    for (const unsigned s : order_)
      h = (h ^ (std::uint64_t{start_[s]} << 32 | present_[s])) * 0x9E3779B97F4A7C15u, h ^= h >> 29;
    return static_cast<std::size_t>(h);
  }

  void list_state(state::Visitor& list);
  /// Which segment is where does not matter, only their order of use.
  friend bool operator==(const Cache& a, const Cache& b) {
    for (unsigned i = 0; i < segment_count; ++i) {
      const unsigned s = a.order_[i], t = b.order_[i];
      if (a.start_[s] != b.start_[t] || a.present_[s] != b.present_[t] || a.words_[s] != b.words_[t]) return false;
    }
    return true;
  }

 private:
  static constexpr Address nowhere = ~Address{0};  // no segment begins here: a start address has 27 bits

  // The four segments are compared at once, for this is asked about each block.
  unsigned segment_of(Address address) const {
    static_assert(segment_count == 4);
    const __m128i starts = _mm_loadu_si128(reinterpret_cast<const __m128i*>(start_.data()));
    const __m128i equal = _mm_cmpeq_epi32(starts, _mm_set1_epi32(static_cast<int>(address >> 5)));
    const auto bits = static_cast<unsigned>(_mm_movemask_ps(_mm_castsi128_ps(equal)));
    return static_cast<unsigned>(std::countr_zero(bits | 1u << segment_count));
  }
  /// The same contents, the most recently used segment in place 0.
  Cache in_order_of_use() const {
    Cache ordered;
    for (unsigned i = 0; i < segment_count; ++i) {
      ordered.words_[i] = words_[order_[i]];
      ordered.present_[i] = present_[order_[i]];
      ordered.start_[i] = start_[order_[i]];
    }
    return ordered;
  }
  void move_to_front(unsigned segment) {
    const auto newest = static_cast<std::uint8_t>(segment);
    std::uint8_t moved = std::exchange(order_[0], newest);
    for (std::size_t at = 1; moved != newest; ++at) std::swap(moved, order_[at]);
  }

  std::array<std::array<Word, segment_words>, segment_count> words_{};
  std::array<Word, segment_count> present_{};  // P flags
  std::array<Address, segment_count> start_{nowhere, nowhere, nowhere, nowhere};
  std::array<std::uint8_t, segment_count> order_{0, 1, 2, 3};  // most recently used first
};

}  // namespace c40
