#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace c40 {

/// Some of the cycles around T, the cycle in which the next instruction without conflicts would execute. A cycle that
/// is too early or too late for the set is never in it.
struct CycleSet {
  static constexpr int before = 128, from = 64;  ///< T - before to T + from - 1
  static constexpr int word_bits = 64;

  bool has(int cycle) const { return holds(cycle) && (words[word_of(cycle)] & bit_of(cycle)) != 0; }
  void put(int cycle, bool in = true) {
    if (!holds(cycle)) return;
    std::uint64_t& word = words[word_of(cycle)];
    word = in ? word | bit_of(cycle) : word & ~bit_of(cycle);
  }
  bool empty() const {
    static_assert(before + from == 3 * word_bits);
    return (words[0] | words[1] | words[2]) == 0;
  }
  /// T advances by `cycles`, which is not negative.
  void advance(int cycles) {
    if (empty()) return;  // as most are
    const auto whole = static_cast<std::size_t>(cycles / word_bits);
    const int rest = cycles % word_bits;
    for (std::size_t i = 0; i < words.size(); ++i) {
      const auto word = [&](std::size_t n) { return n < words.size() ? words[n] : 0; };
      words[i] = word(i + whole) >> rest | (rest == 0 ? 0 : word(i + whole + 1) << (word_bits - rest));
    }
  }
  void forget_before(int cycle) {
    if (empty()) return;
    const int gone = std::clamp(cycle + before, 0, before + from);
    for (std::size_t i = 0; i < words.size(); ++i) {
      const int here = gone - static_cast<int>(i) * word_bits;
      if (here >= word_bits) words[i] = 0;
      if (here > 0 && here < word_bits) words[i] &= ~std::uint64_t{0} << here;
    }
  }
  friend bool operator==(const CycleSet&, const CycleSet&) = default;

  static constexpr bool holds(int cycle) { return cycle >= -before && cycle < from; }
  static constexpr std::size_t word_of(int cycle) { return static_cast<std::size_t>(cycle + before) / word_bits; }
  static constexpr std::uint64_t bit_of(int cycle) { return std::uint64_t{1} << (cycle + before) % word_bits; }

  std::array<std::uint64_t, (before + from) / word_bits> words{};  ///< bit 0 of the first is T - before
};

}  // namespace c40
