#pragma once
// A second arithmetic of the TMS320C4x in integers, written from the reference text by itself: it shares no code with
// the emulator (emulator/c40) and none with the specification in Python (tests/spec), and is compared with both by
// campaigns.
#include <cstdint>
#include <string_view>
#include <vector>

namespace reference {

/// One case of one operation. R0 holds `d` before, R1 `a`, R2 `b` (40 bits, exponent in 39..32).
struct Case {
  std::uint64_t d = 0, a = 0, b = 0;
  std::uint32_t status = 0;
  std::uint32_t selector = 0;  ///< byte, half-word or condition
};

struct Result {
  std::uint64_t d = 0;  ///< R0 after; of an address update, the address register in bits 31..0
  std::uint32_t status = 0;
  bool operator==(const Result&) const = default;
};

/// What an operation takes: floats, words, or an address, a step and a block size (a, b, d).
enum class Operands : std::uint8_t { floats, words, address };

struct Operation {
  std::string_view name;
  Operands operands;
  std::uint32_t selectors;  ///< number of values that `selector` takes
  Result (*run)(const Case&);
};

const std::vector<Operation>& operations();

}  // namespace reference
