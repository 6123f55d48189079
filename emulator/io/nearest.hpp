#pragma once
// The known word that a user most likely meant.
#include <algorithm>
#include <cstddef>
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

/// "; did you mean \"waits\"?", or nothing if no word is near.
template <class Words>
std::string did_you_mean(std::string_view given, const Words& words) {
  std::string_view best;
  std::size_t least = std::max<std::size_t>(2, given.size() / 2) + 1;
  for (const std::string_view word : words)
    if (const std::size_t distance = edit_distance(given, word); distance < least) least = distance, best = word;
  return best.empty() ? std::string() : "; did you mean \"" + std::string(best) + "\"?";
}

}  // namespace io
