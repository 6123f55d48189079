// Network files, whose chips may have the program a.asm and the board b.toml. A small network that is accepted runs for
// two microseconds.
#include "machine/networks/network_file.hpp"

#include "fuzz/target.hpp"
#include "toolchain/assembler/assembler.hpp"

namespace {

// Sends a word through two ports each, writes to a window, which may lead to a shared memory, and waits for a word.
constexpr std::string_view source = R"(
        .text
start:  ldhi 10h,ar0
        ldi 7,r0
        sti r0,*+ar0(42h)
        sti r0,*+ar0(52h)
        ldhi 0c000h,ar1
        sti r0,*ar1
        ldi *+ar0(71h),r1
end:    bu end
)";
constexpr std::string_view board = R"(
name = "b"
[[region]]
name = "RAM"
base = 0x300000
words = 0x1000
bus = "local"
[[region]]
name = "window"
kind = "window"
base = 0xC0000000
words = 0x1000
bus = "global"
[[device]]
name = "timer"
kind = "timer"
base = 0xC0000800
pin = "IIOF1"
)";

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 8192, few_chips = 3;
  constexpr std::uint64_t few_words = 1u << 16;
  if (size > most) return 0;
  static const fuzz::InputFile file("network.toml", {{"a.asm", source}, {"b.toml", board}});
  static const toolchain::Image program = toolchain::assemble_text(source, "program");
  fuzz::Input input(data, size);
  const std::string& path = file.write(input.text());
  machine::NetworkDescription network;
  const auto read = [&] { network = machine::read_network(path, [](const std::string&) { return program; }); };
  if (!fuzz::done<machine::NetworkError, machine::BoardError>(read)) return 0;
  std::uint64_t words = 0;
  for (const machine::SharedMemory& memory : network.memories) words += memory.words;
  if (network.chips.size() > few_chips || words > few_words) return 0;
  fuzz::done<machine::NetworkError, machine::BoardError>([&] {
    machine::Network made(network);
    made.run_until(machine::Time{2'000'000});
    made.check_words();
    for (std::size_t n = 0; n < made.chip_count(); ++n) made.describe(n);
  });
  return 0;
}
