#pragma once
// The known word that a user most likely meant.
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace io {

/// Number of letters to change, add or leave out.
inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j)
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])}));
  }
  return row[b.size()];
}

/// The word that differs from `given` by the fewest letters, at most `most`; empty: no word is near.
template <class Words>
std::string_view nearest(std::string_view given, const Words& words, std::size_t most) {
  std::string_view best;
  for (const std::string_view word : words)
    if (const std::size_t distance = edit_distance(given, word); distance <= most && !word.empty()) {
      if (distance == 0) return word;
      most = distance - 1, best = word;
    }
  return best;
}

/// "; did you mean \"waits\"?", or nothing if no word is near.
inline std::string suggestion(std::string_view near, char quote = '"') {
  return near.empty() ? std::string() : "; did you mean " + std::string(1, quote).append(near) + quote + "?";
}

template <class Words>
std::string did_you_mean(std::string_view given, const Words& words) {
  return suggestion(nearest(given, words, std::max<std::size_t>(2, given.size() / 2)));
}

/// The symbol of a program that a user most likely meant. Programs have many short symbols, so fewer letters may
/// differ.
template <class Words>
std::string_view nearest_symbol(std::string_view given, const Words& symbols) {
  return nearest(given, symbols, std::max<std::size_t>(1, given.size() / 3));
}

/// "a, b or c"
template <class Words>
std::string one_of(const Words& words) {
  std::string all;
  for (auto word = words.begin(); word != words.end(); ++word) {
    if (word != words.begin()) all += std::next(word) == words.end() ? " or " : ", ";
    all += *word;
  }
  return all;
}

}  // namespace io
