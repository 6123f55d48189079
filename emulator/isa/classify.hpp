#pragma once
// Counts what each word is: the proof that the table covers each C4x word once (c40-isa.md 3.1, 12).
#include <array>
#include <cstdint>
#include <vector>

#include "isa/decode.hpp"

namespace isa {

struct Classification {
  static constexpr std::size_t reasons = 8;

  std::uint64_t words = 0;
  std::vector<std::uint64_t> rows;                ///< Instructions, by the index of their row.
  std::array<std::uint64_t, reasons> reserved{};  ///< By Reserved::Reason.
  std::uint64_t ambiguous = 0;                    ///< Words that match more than one row: a fault in the table.

  std::uint64_t instructions() const;
  std::uint64_t reserved_words() const;
  Classification& operator+=(const Classification& other);
};

/// Decodes `count` words from `first` on and counts them. Around 30 million words per second.
Classification classify(Word first, std::uint64_t count);

}  // namespace isa
