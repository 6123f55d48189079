#include "plant/numerics/noise.hpp"

#include <cmath>

#include "plant/numerics/math.hpp"

namespace plant {
namespace {

// splitmix64's output function: a permutation of the 64-bit words that mixes them well.
std::uint64_t mix(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

// `part` 1 is the second number for a normal deviate. Different (stream, part, sample) have different keys, and
// different results.
double draw(std::uint64_t seed, Stream stream, std::uint64_t part, std::int64_t sample) {
  const std::uint64_t key =
      static_cast<std::uint64_t>(stream) << 56 | part << 48 | (static_cast<std::uint64_t>(sample) & 0xFFFFFFFFFFFFULL);
  return (static_cast<double>(mix(mix(seed) ^ key) >> 11) + 0.5) * 0x1p-53;
}

}  // namespace

double uniform(std::uint64_t seed, Stream stream, std::int64_t sample) { return draw(seed, stream, 0, sample); }

double normal(std::uint64_t seed, Stream stream, std::int64_t sample) {
  const double radius = std::sqrt(-2.0 * log(draw(seed, stream, 0, sample)));
  return radius * cos(2.0 * std::numbers::pi * draw(seed, stream, 1, sample));
}

}  // namespace plant
