// Every word, or every STEP-th: the emulator's decoder and the reference must call the same ones instructions.
//
//   word_sweep [STEP]     exit status 1 if one differs
#include <fmt/format.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <variant>

#include "isa/decode.hpp"
#include "legality.hpp"

int main(int argc, char** argv) {
  const std::uint64_t step = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1;
  if (argc > 2 || step == 0) {
    fmt::print(stderr, "usage: word_sweep [STEP]\n");
    return 2;
  }
  constexpr std::uint64_t words = std::uint64_t{1} << 32, most_shown = 20;
  std::uint64_t swept = 0, instructions = 0, differing = 0;
  for (std::uint64_t at = 0; at < words; at += step, ++swept) {
    const auto word = static_cast<std::uint32_t>(at);
    const isa::Decoded decoded = isa::decode(word);
    const bool legal = std::holds_alternative<isa::Instruction>(decoded);
    instructions += legal ? 1 : 0;
    if (legal == reference::is_instruction(word)) [[likely]]
      continue;
    if (differing++ < most_shown)
      fmt::print("{:08X} is {} to the decoder, and {} to the reference\n", word, legal ? "an instruction" : "reserved",
                 legal ? "reserved" : "an instruction");
  }
  fmt::print("{} words, {} instructions, {} reserved: {} differ\n", swept, instructions, swept - instructions,
             differing);
  return differing == 0 ? 0 : 1;
}
