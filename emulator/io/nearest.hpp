#pragma once
// The known word that a user most likely meant.
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace io {

/// A bit for each letter of the word; two letters may share one.
inline std::uint64_t letters(std::string_view word) {
  std::uint64_t found = 0;
  for (const char letter : word) found |= std::uint64_t{1} << (static_cast<unsigned char>(letter) & 63);
  return found;
}

/// Number of letters to change, add, leave out, or exchange with the next one; `most + 1` if it is more than `most`.
inline std::size_t edit_distance(std::string_view a, std::string_view b, std::size_t most) {
  if (std::max(a.size(), b.size()) - std::min(a.size(), b.size()) > most) return most + 1;
  // Each letter that only one of the words has is a change. Most words differ by more of these than is asked for.
  const std::uint64_t in_a = letters(a), in_b = letters(b);
  const int only_in_one = std::max(std::popcount(in_a & ~in_b), std::popcount(in_b & ~in_a));
  if (static_cast<std::size_t>(only_in_one) > most) return most + 1;
  // Only places within `most` of the diagonal can be reached by so few changes; the others count as too far.
  const std::size_t far = most + 1;
  std::vector<std::size_t> before_last(b.size() + 1, far), last(b.size() + 1, far), row(b.size() + 1, far);
  for (std::size_t j = 0; j <= std::min(most, b.size()); ++j) row[j] = j;
  for (std::size_t i = 1, least_before = 0; i <= a.size(); ++i) {
    std::swap(before_last, last);
    std::swap(last, row);
    const std::size_t first = i > most ? i - most : 1, end = std::min(b.size(), i + most);
    std::size_t least = row[first - 1] = i > most ? far : i;
    for (std::size_t j = first; j <= end; ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before_last[j - 2] + 1);
      least = std::min(least, row[j]);
    }
    if (end < b.size()) row[end + 1] = far;
    if (std::min(least, least_before) > most) return far;  // each later row comes from these two
    least_before = least;
  }
  return std::min(row[b.size()], far);
}

/// The number of letters in which a word may differ from the one that was meant. One letter is near to every letter.
inline std::size_t most_wrong(std::string_view given) {
  return given.size() < 2 ? 0 : std::max<std::size_t>(1, given.size() / 3);
}

/// The word that differs from `given` by the fewest letters, at most `most`; empty: no word is near. Of equally near
/// words, one that `given` is the beginning of: `.endi` means `.endif` rather than `.end`. Otherwise the first.
template <class Words>
std::string_view nearest(std::string_view given, const Words& words, std::size_t most) {
  std::string_view best;
  for (const std::string_view word : words)
    if (const std::size_t distance = edit_distance(given, word, most); distance <= most && !word.empty()) {
      if (distance == 0) return word;
      most = distance - 1, best = word;
    }
  for (const std::string_view word : words)
    if (!best.empty() && word.size() == given.size() + most + 1 && word.starts_with(given)) return word;
  return best;
}

/// "did you mean \"waits\"?"
inline std::string meant(std::string_view near, char quote = '"') {
  return "did you mean " + std::string(1, quote).append(near) + quote + "?";
}

/// "; did you mean \"waits\"?", or nothing if no word is near.
inline std::string suggestion(std::string_view near, char quote = '"') {
  return near.empty() ? std::string() : "; " + meant(near, quote);
}

/// Whether the word begins with `given`, or has it in it. Too many words have fewer than four letters in them.
inline bool has_in_it(std::string_view word, std::string_view given) {
  const std::size_t at = word.find(given);
  return given.size() >= 2 && at != std::string_view::npos && (at == 0 || given.size() >= 4);
}

/// Suggests the nearest word, else one that has the given one in it. Dashes before an option do not count.
template <class Words>
std::string did_you_mean(std::string_view given, const Words& words) {
  const std::string_view letters = given.substr(std::min(given.find_first_not_of('-'), given.size()));
  std::string_view best = nearest(given, words, most_wrong(letters));
  for (const std::string_view word : words)
    if (best.empty() && has_in_it(word, letters)) best = word;
  return suggestion(best);
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
