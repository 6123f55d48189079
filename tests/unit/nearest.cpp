// Near names: the distance of two words, against its definition.
#include "io/nearest.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace {

constexpr std::size_t longest = 4;

std::set<std::string> words_of(std::string_view letters) {
  std::set<std::string> all{""};
  std::set<std::string> last = all;
  for (std::size_t length = 1; length <= longest; ++length) {
    std::set<std::string> next;
    for (const std::string& word : last)
      for (const char letter : letters) next.insert(word + letter);
    all.insert(next.begin(), next.end());
    last = std::move(next);
  }
  return all;
}

/// Whether one step leads from `a` to `b`: a letter changed, added or left out, or two neighbours exchanged.
bool is_step(const std::string& a, const std::string& b) {
  if (a.size() > b.size()) return is_step(b, a);
  for (std::size_t at = 0; at < b.size(); ++at) {
    if (a.size() < b.size() && b.substr(0, at) + b.substr(at + 1) == a) return true;
    if (a.size() < b.size()) continue;
    std::string changed = a;
    changed[at] = b[at];
    if (changed == b) return true;
    changed = a;
    if (at > 0) std::swap(changed[at - 1], changed[at]);
    if (changed == b) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("a distance is 1 for words one step apart, and the same for every limit that allows it") {
  const std::set<std::string> words = words_of("ab\xE1");  // 'a' and 0xE1 share a bit of `letters`
  std::map<std::string, std::vector<std::string>> beside;
  for (const std::string& a : words)
    for (const std::string& b : words)
      if (a != b && is_step(a, b)) beside[a].push_back(b);
  for (const std::string& a : words) {
    const auto near = [&](const std::string& b) { return std::ranges::find(beside[a], b) != beside[a].end(); };
    for (const std::string& b : words) {
      const std::size_t distance = io::edit_distance(a, b, longest);
      CAPTURE(a);
      CAPTURE(b);
      CHECK(io::edit_distance(b, a, longest) == distance);
      CHECK((distance == 0) == (a == b));
      CHECK((distance == 1) == near(b));
      for (std::size_t most = 0; most <= longest; ++most)
        CHECK(io::edit_distance(a, b, most) == std::min(distance, most + 1));
    }
  }
}

TEST_CASE("of equally near words, one that begins with the given one is meant, otherwise the first") {
  const std::vector<std::string> words{".end", ".endr", ".endif", ".word"};
  CHECK(io::nearest(".endi", words, 1) == ".endif");
  CHECK(io::nearest(".ends", words, 1) == ".end");
  CHECK(io::nearest(".endr", words, 1) == ".endr");
  CHECK(io::nearest(".wrd", words, 1) == ".word");
  CHECK(io::nearest(".xyz", words, 1).empty());
  CHECK(io::nearest("", std::vector<std::string>{"a"}, 0).empty());
}

TEST_CASE("letters that only one word has do not make words differ by more than they do") {
  CHECK(io::edit_distance("abcdef", "ghijkl", 9) == 6);
  CHECK(io::edit_distance("abcdef", "ghijkl", 6) == 6);
  CHECK(io::edit_distance("abcdef", "ghijkl", 5) == 6);
  CHECK(io::edit_distance("aaaa", "abcd", 9) == 3);
  CHECK(io::edit_distance("dsp", "dsps_in_all", 8) == 8);
  CHECK(io::edit_distance("recieve", "receive", 1) == 1);
}
