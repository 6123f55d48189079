#pragma once
// The cases of a campaign: every other one pairs two edge operands until all pairs have been; the others are random,
// near edges, near each other, and anywhere.
#include <cstdint>

#include "reference.hpp"

namespace reference {

class Cases {
 public:
  Cases(const Operation& operation, std::uint64_t seed);
  Case next();
  /// Number of pairs of edge operands; twice as many cases hold them all.
  std::uint64_t edge_pairs() const;

 private:
  std::uint64_t random();
  std::uint32_t below(std::uint32_t limit) { return static_cast<std::uint32_t>((random() >> 32) * limit >> 32); }
  std::uint64_t any_float();
  std::uint64_t near(std::uint64_t other);
  std::uint64_t any_word();
  std::uint32_t any_mantissa();
  std::uint64_t operand();
  std::uint64_t edge(std::uint64_t number) const;
  std::uint64_t edge_count() const;
  Case address_case();
  std::uint32_t status();

  const Operation& operation_;
  std::uint64_t state_;
  std::uint64_t number_ = 0;
};

}  // namespace reference
