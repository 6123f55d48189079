// Any words: their text for each processor assembles to the same words.
#include "toolchain/disassembler/disassembly.hpp"
#include "fuzz/target.hpp"
#include "toolchain/assembler/assembler.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 2048;
  if (size > most) return 0;
  fuzz::Input input(data, size);
  toolchain::Image image;
  toolchain::Image::Section text{.name = ".text", .address = 0x300000, .size = 0, .words = {}, .loaded = true};
  while (!input.empty()) text.words.push_back(input.word());
  if (text.words.empty()) return 0;
  text.size = static_cast<toolchain::Address>(text.words.size());
  image.entry = text.address;
  image.sections.push_back(text);
  toolchain::Options options;
  options.dialect = toolchain::Dialect::ti;
  for (const isa::Cpu cpu : {isa::Cpu::c40, isa::Cpu::c3x}) {
    image.cpu = options.cpu = cpu;
    toolchain::disassembly(image);
    const toolchain::Image again = toolchain::assemble_text(toolchain::source_of(image), "disassembled", options);
    fuzz::expect(again.sections.size() == 1 && again.sections[0].words == text.words,
                 "the source has other words than the program");
  }
  return 0;
}
