// Assembler source. If the source assembles, the program is written as COFF and read back unchanged.
#include "toolchain/assembler/assembler.hpp"
#include "fuzz/target.hpp"
#include "toolchain/objects/coff.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 4096;
  if (size == 0 || size > most) return 0;
  fuzz::Input input(data, size);
  const std::uint8_t choice = input.byte();
  toolchain::Options options;
  if ((choice & 1) != 0) options.dialect = toolchain::Dialect::gnu;
  if ((choice & 4) != 0) options.cpu = isa::Cpu::c3x;
  if ((choice & 2) != 0) {
    toolchain::AssembledObject assembled;
    if (!fuzz::done<toolchain::AssemblyError>(
            [&] { assembled = toolchain::assemble_object_text(input.text(), "input", options); }))
      return 0;
    toolchain::listing(assembled.listed);
    std::vector<std::byte> written;
    if (fuzz::done<std::runtime_error>([&] { written = toolchain::coff_bytes(assembled.object); }))
      toolchain::read_object(written, "written");
    return 0;
  }
  toolchain::Image image;
  if (!fuzz::done<toolchain::AssemblyError>([&] { image = toolchain::assemble_text(input.text(), "input", options); }))
    return 0;
  toolchain::listing(image);
  std::vector<std::byte> written;
  if (!fuzz::done<std::runtime_error>([&] { written = toolchain::coff_bytes(image); })) return 0;
  const toolchain::Image again = toolchain::read_coff(written, "written");
  fuzz::expect(again.cpu == image.cpu, "the processor changes when a program is written and read");
  fuzz::expect(again.entry == image.entry, "the entry changes when a program is written and read");
  fuzz::expect(again.sections.size() == image.sections.size(), "sections change when a program is written and read");
  for (std::size_t n = 0; n < again.sections.size(); ++n)
    fuzz::expect(again.sections[n].words == image.sections[n].words, "words change when a program is written and read");
  return 0;
}
