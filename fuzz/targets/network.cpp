// Network files, of programs that do nothing. A small network that is accepted runs for two microseconds.
#include "machine/networks/network_file.hpp"

#include "fuzz/target.hpp"
#include "toolchain/assembler/assembler.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 8192, few_chips = 3;
  constexpr std::uint64_t few_words = 1u << 16;
  if (size > most) return 0;
  static const fuzz::InputFile file("network.toml");
  static const toolchain::Image program =
      toolchain::assemble_text("start: ldi 1,r0\n addi r0,r0\nend: bu end\n", "program");
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
