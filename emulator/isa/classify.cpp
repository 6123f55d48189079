#include "isa/classify.hpp"

#include <numeric>

namespace isa {
namespace {

constexpr unsigned top_bits = 11;

/// The rows that words with these upper bits can match. G and T are among these bits, so the modes are decided here.
std::vector<const Row*> rows_for(Word top) {
  std::vector<const Row*> out;
  const Word word = top << (32 - top_bits);
  const Word mask = ~Word{0} << (32 - top_bits);
  for (const Row& row : rows())
    if (((word ^ row.bits.match) & row.bits.mask & mask) == 0 && (row.modes >> (top & 3) & 1) != 0) out.push_back(&row);
  return out;
}

}  // namespace

std::uint64_t Classification::instructions() const {
  return std::accumulate(rows.begin(), rows.end(), std::uint64_t{0});
}

std::uint64_t Classification::reserved_words() const {
  return std::accumulate(reserved.begin(), reserved.end(), std::uint64_t{0});
}

Classification& Classification::operator+=(const Classification& other) {
  words += other.words;
  ambiguous += other.ambiguous;
  rows.resize(isa::rows().size());
  for (std::size_t i = 0; i < other.rows.size(); ++i) rows[i] += other.rows[i];
  for (std::size_t i = 0; i < reasons; ++i) reserved[i] += other.reserved[i];
  return *this;
}

Classification classify(Word first, std::uint64_t count) {
  Classification out;
  out.rows.resize(rows().size());
  out.words = count;
  std::vector<const Row*> candidates;
  Word last_top = ~Word{0};
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto word = static_cast<Word>(first + i);
    if (const Word top = word >> (32 - top_bits); top != last_top) {
      candidates = rows_for(top);
      last_top = top;
    }
    int suits = 0;
    for (const Row* row : candidates) suits += (word & row->bits.mask) == row->bits.match ? 1 : 0;
    if (suits > 1) ++out.ambiguous;
    const Decoded decoded = decode(word);
    if (const auto* instruction = std::get_if<Instruction>(&decoded))
      ++out.rows[static_cast<std::size_t>(instruction->row - rows().data())];
    else
      ++out.reserved[static_cast<std::size_t>(std::get<Reserved>(decoded).reason)];
  }
  return out;
}

}  // namespace isa
