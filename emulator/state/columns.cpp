#include "state/columns.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include "state/visitor.hpp"

namespace state {
namespace {

using Word = std::uint64_t;  // all sums and differences are modulo 2^64, so that each can be undone

constexpr unsigned orders = 6;  // differences of order 0 to 5
constexpr unsigned readings = 3;

/// How a word is read as an integer.
enum class Reading : std::uint8_t { as_it_is, ordered, scaled };

// Orders the integers as the doubles with the same bits: neighbouring doubles are one apart. The function is its own
// inverse.
Word ordered(Word bits) { return (bits >> 63) != 0 ? bits ^ std::numeric_limits<std::int64_t>::max() : bits; }

// Doubles that are whole multiples of 2^-30 (the rows of a course are), and small enough that this multiple alone gives
// their bits.
constexpr double parts = 1 << 30;
constexpr double most_multiple = 1LL << 52;

bool is_scaled(Word bits) {
  const double multiple = std::bit_cast<double>(bits) * parts;
  if (!(multiple > -most_multiple && multiple < most_multiple)) return false;
  const double whole = static_cast<double>(static_cast<std::int64_t>(multiple)) / parts;
  return std::bit_cast<Word>(whole) == bits;  // false for a zero with a sign
}

Word read(Word bits, Reading reading) {
  if (reading == Reading::as_it_is) return bits;
  if (reading == Reading::ordered) return ordered(bits);
  return static_cast<Word>(static_cast<std::int64_t>(std::bit_cast<double>(bits) * parts));
}

Word written(Word number, Reading reading) {
  if (reading == Reading::as_it_is) return number;
  if (reading == Reading::ordered) return ordered(number);
  return std::bit_cast<Word>(static_cast<double>(static_cast<std::int64_t>(number)) / parts);
}

// Maps small numbers of either sign to small numbers.
Word folded(Word difference) { return difference << 1 ^ (0 - (difference >> 63)); }
Word unfolded(Word number) { return number >> 1 ^ (0 - (number & 1)); }

/// The differences of each order of a sequence of numbers.
class Differences {
 public:
  /// The differences of orders 0, 1, 2, ...
  const std::array<Word, orders>& of(Word number) {
    std::array<Word, orders> now{};
    now[0] = number;
    for (unsigned order = 1; order < orders; ++order) now[order] = now[order - 1] - last_[order - 1];
    return last_ = now;
  }
  /// The number whose difference of that order is `difference`.
  Word number(Word difference, unsigned order) {
    last_[order] = difference;
    for (unsigned lower = order; lower-- > 0;) last_[lower] += last_[lower + 1];
    return last_[0];
  }

 private:
  std::array<Word, orders> last_{};
};

Word word_at(const char* table, std::size_t index) {
  Word word = 0;
  std::memcpy(&word, table + index * sizeof word, sizeof word);
  return word;
}

struct How {
  Reading reading = Reading::as_it_is;
  unsigned order = 0;
  char byte() const { return static_cast<char>(static_cast<unsigned>(reading) * orders + order); }
};

/// The reading and the order with the shortest differences.
How best(const char* table, std::size_t rows, std::size_t columns, std::size_t column) {
  std::array<std::array<std::uint64_t, orders>, readings> bits{};
  std::array<Differences, readings> differences;
  bool scales = true;
  for (std::size_t row = 0; row < rows; ++row) {
    const Word word = word_at(table, row * columns + column);
    scales = scales && is_scaled(word);
    for (unsigned reading = 0; reading < readings; ++reading) {
      if (reading == static_cast<unsigned>(Reading::scaled) && !scales) continue;
      const auto& all = differences[reading].of(read(word, static_cast<Reading>(reading)));
      for (unsigned order = 0; order < orders; ++order)
        bits[reading][order] += static_cast<unsigned>(std::bit_width(folded(all[order])));
    }
  }
  How how;
  std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
  for (unsigned reading = 0; reading < (scales ? readings : readings - 1); ++reading)
    for (unsigned order = 0; order < orders; ++order)
      if (bits[reading][order] < least) least = bits[reading][order], how = {static_cast<Reading>(reading), order};
  return how;
}

How how_of(char byte) {
  const auto code = static_cast<unsigned char>(byte);
  if (code >= readings * orders) throw StateError("the snapshot is damaged: a column has an unknown form");
  return {static_cast<Reading>(code / orders), code % orders};
}

}  // namespace

std::string to_columns(std::string& text, const std::vector<Table>& tables) {
  std::string how;
  for (const Table& table : tables) {
    std::string out(table.bytes(), '\0');
    const char* from = text.data() + table.offset;
    for (std::size_t column = 0; column < table.columns; ++column) {
      const How one = best(from, table.rows, table.columns, column);
      how += one.byte();
      char* const planes = out.data() + column * table.rows * sizeof(Word);
      Differences differences;
      for (std::size_t row = 0; row < table.rows; ++row) {
        Word left = folded(differences.of(read(word_at(from, row * table.columns + column), one.reading))[one.order]);
        for (std::size_t plane = 0; plane < sizeof left; ++plane, left >>= 8)
          planes[plane * table.rows + row] = static_cast<char>(left & 0xFF);
      }
    }
    text.replace(table.offset, out.size(), out);
  }
  return how;
}

void from_columns(std::string& text, const std::vector<Table>& tables, std::string_view how) {
  auto next = how.begin();
  for (const Table& table : tables) {
    std::string out(table.bytes(), '\0');
    for (std::size_t column = 0; column < table.columns; ++column) {
      if (next == how.end())
        throw StateError("the snapshot is damaged: it has more columns than descriptions of columns");
      const How one = how_of(*next++);
      const char* const planes = text.data() + table.offset + column * table.rows * sizeof(Word);
      Differences differences;
      for (std::size_t row = 0; row < table.rows; ++row) {
        Word left = 0;
        for (std::size_t plane = sizeof left; plane-- > 0;)
          left = left << 8 | static_cast<unsigned char>(planes[plane * table.rows + row]);
        const Word word = written(differences.number(unfolded(left), one.order), one.reading);
        std::memcpy(out.data() + (row * table.columns + column) * sizeof word, &word, sizeof word);
      }
    }
    text.replace(table.offset, out.size(), out);
  }
}

}  // namespace state
