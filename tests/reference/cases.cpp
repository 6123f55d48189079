#include "cases.hpp"

#include <array>
#include <vector>

namespace reference {
namespace {

using u32 = std::uint32_t;
using u64 = std::uint64_t;

constexpr std::array exponents{-128, -127, -126, -125, -33, -32, -31, -2,  -1,  0,  1,
                               22,   23,   24,   29,   30,  31,  32,  125, 126, 127};
constexpr std::array<u32, 23> mantissas{0,          1,          0x7F,       0x80,       0x81,       0xFF,
                                        0x100,      0x3FFFFFFF, 0x40000000, 0x7FFFFF00, 0x7FFFFF7F, 0x7FFFFF80,
                                        0x7FFFFFFF, 0x80000000, 0x80000001, 0x8000007F, 0x80000080, 0x80000100,
                                        0xC0000000, 0xFFFFFF00, 0xFFFFFF7F, 0xFFFFFF80, 0xFFFFFFFF};

u64 pack(int e, u32 m) { return static_cast<u64>(e & 0xFF) << 32 | m; }

const std::vector<u32>& edge_words() {
  static const std::vector<u32> words = [] {
    std::vector<u32> out{0xFFFF,     0xFFFF0000, 0x00FF00FF, 0x7FFF8000, 0x46340000, 0xB504F334,
                         0x0000B505, 0x55555555, 0xAAAAAAAA, 0x7F800000, 0xFF800000, 0x007FFFFF,
                         0x00800000, 0x80800000, 0x7F7FFFFF, 0xFF7FFFFF, 0x80000000, 0x80000001};
    for (u32 i = 0; i < 4; ++i) out.insert(out.end(), {i, 0u - i, 0x7FFFFFFFu - i, 0x80000000u + i});
    for (u32 bit = 0; bit < 32; ++bit) out.insert(out.end(), {1u << bit, ~(1u << bit)});
    for (u32 count = 30; count < 35; ++count) out.insert(out.end(), {count, 0u - count, 0x80u - count});
    for (u32 count = 62; count < 66; ++count) out.insert(out.end(), {count, 0u - count});
    return out;
  }();
  return words;
}

}  // namespace

Cases::Cases(const Operation& operation, u64 seed) : operation_(operation), state_(seed * 0x9E3779B97F4A7C15u) {
  for (const char letter : operation.name) state_ = (state_ ^ static_cast<unsigned char>(letter)) * 0x100000001B3u;
}

// splitmix64
u64 Cases::random() {
  u64 z = state_ += 0x9E3779B97F4A7C15u;
  z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
  z = (z ^ z >> 27) * 0x94D049BB133111EBu;
  return z ^ z >> 31;
}

u64 Cases::edge_count() const {
  return operation_.operands == Operands::floats ? exponents.size() * mantissas.size() : edge_words().size();
}

u64 Cases::edge_pairs() const { return operation_.operands == Operands::address ? 0 : edge_count() * edge_count(); }

u64 Cases::edge(u64 number) const {
  if (operation_.operands == Operands::floats)
    return pack(exponents[number / mantissas.size()], mantissas[number % mantissas.size()]);
  return edge_words()[number];
}

u32 Cases::any_mantissa() {
  const u64 bits = random();
  const auto word = static_cast<u32>(bits);
  switch (bits >> 60) {
    case 0:
    case 1:
    case 2:
    case 3: return mantissas[below(mantissas.size())];
    case 4:
    case 5: return mantissas[below(mantissas.size())] + (word & 7) - 4;
    case 6: return (word & 0x80000000u) ^ (word & 0x7FFFFFFFu) >> (bits >> 32 & 31);
    default: return word;
  }
}

u64 Cases::any_float() {
  const u64 bits = random();
  switch (bits >> 61) {
    case 0: return edge(below(static_cast<u32>(edge_count())));
    case 1:
    case 2: return pack(exponents[below(exponents.size())] + static_cast<int>(below(3)) - 1, any_mantissa());
    case 3:
    case 4:
    case 5: return pack(static_cast<int>(below(73)) - 36, any_mantissa());
    default: return pack(static_cast<int>(below(256)) - 128, any_mantissa());
  }
}

/// Cancels against the other operand, or stands a few places away from it.
u64 Cases::near(u64 other) {
  constexpr std::array<int, 16> distances{0, 0, 0, 0, 1, -1, 2, -2, 30, 31, 32, 33, 34, -31, -32, -33};
  auto m = static_cast<u32>(other);
  switch (below(6)) {
    case 0: break;
    case 1: m ^= 0x80000000u; break;
    case 2: m = 0u - m; break;
    case 3: m = (0u - m) ^ 0x80000000u; break;
    default: m = any_mantissa();
  }
  return pack(static_cast<int>(other >> 32) + distances[below(16)], m + below(3) - 1);
}

u64 Cases::any_word() {
  const u64 bits = random();
  const auto word = static_cast<u32>(bits);
  // The exponent byte, which integer operations keep.
  const u64 top = (bits >> 32 & 0xFF) << 32;
  switch (bits >> 61) {
    case 0:
    case 1: return top | edge_words()[below(static_cast<u32>(edge_words().size()))];
    case 2: return top | word >> below(32);
    case 3: return top | (0u - (word >> below(32)));
    default: return top | word;
  }
}

u64 Cases::operand() { return operation_.operands == Operands::floats ? any_float() : any_word(); }

/// C, the flags, OVM and some mode bits; no repeat mode, no SET COND, which would not matter.
u32 Cases::status() { return static_cast<u32>(random() >> 40) & 0x0EFFu; }

Case Cases::address_case() {
  Case c;
  const u64 bits = random();
  c.d = (bits & 15) == 0 ? static_cast<u32>(bits >> 32) : 1 + below((bits & 16) != 0 ? 64 : 1u << 16);
  c.a = static_cast<u32>(random());
  const auto size = static_cast<u32>(c.d);
  // Most steps within the block; some beyond it, where the sum is taken as it is.
  c.b = (bits & 0xE0) == 0 ? static_cast<u32>(random()) : below(size == 0xFFFFFFFFu ? size : size + 1);
  if ((bits & 0x300) == 0) c.b = u64{1} << below(32);
  c.status = status();
  return c;
}

Case Cases::next() {
  const u64 number = number_++;
  if (operation_.operands == Operands::address) return address_case();
  Case c;
  const u64 pair = number / 2, count = edge_count();
  if (number % 2 == 0 && pair < edge_pairs()) {
    c.a = edge(pair % count);
    c.b = edge((pair / count + pair) % count);
    c.d = c.b;
  } else {
    c.a = operand();
    const bool related = operation_.operands == Operands::floats && below(3) == 0;
    c.b = related ? near(c.a) : operand();
    c.d = below(2) == 0 ? c.b : operand();
  }
  c.status = status();
  c.selector = operation_.selectors == 1 ? 0 : below(operation_.selectors);
  return c;
}

}  // namespace reference
