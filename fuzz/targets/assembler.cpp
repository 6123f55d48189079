// Assembler source. If the source assembles, the program is written as COFF and read back unchanged, and is the one
// that the linker makes of its object.
#include <algorithm>
#include <map>

#include "fuzz/target.hpp"
#include "toolchain/assembler/assembler.hpp"
#include "toolchain/linker/linker.hpp"
#include "toolchain/linker/memory_map.hpp"
#include "toolchain/objects/coff.hpp"

namespace {

/// The linker gives these sections words that are in no source.
bool linker_adds_words(const toolchain::Image::Section& section) {
  return section.name == ".cinit" || section.name == ".stack" || section.name == ".sysmem";
}

std::map<toolchain::Address, toolchain::Word> words_of(const toolchain::Image& image) {
  std::map<toolchain::Address, toolchain::Word> words;
  for (const auto& section : image.sections)
    for (std::size_t n = 0; n < section.words.size(); ++n)
      words[section.address + static_cast<toolchain::Address>(n)] = section.words[n];
  return words;
}

void expect_the_linker_agrees(const toolchain::Image& image, std::string_view source,
                              const toolchain::Options& options) {
  if (std::ranges::any_of(image.sections, linker_adds_words)) return;
  toolchain::Linked linked;
  if (!fuzz::done<toolchain::AssemblyError, toolchain::LinkError>([&] {
        linked = toolchain::link({toolchain::assemble_object_text(source, "input", options).object}, {},
                                 toolchain::MemoryMap::standard());
      }))
    return;
  fuzz::expect(words_of(linked.image) == words_of(image), "words differ in the linked object");
  fuzz::expect(linked.image.entry == image.entry, "the entry differs in the linked object");
  for (const auto& [name, value] : linked.image.symbols)
    if (const auto found = image.symbols.find(name); found != image.symbols.end())
      fuzz::expect(found->second == value, "the symbol " + name + " differs in the linked object");
}

}  // namespace

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
  expect_the_linker_agrees(image, input.text(), options);
  return 0;
}
