// emulator asm, emulator disasm
#include <fmt/format.h>

#include "cli/options.hpp"
#include "cli/output_file.hpp"
#include "cli/program.hpp"
#include "isa/disassemble.hpp"
#include "toolchain/coff.hpp"

namespace cli {

int assemble(const AssembleOptions& options) {
  const toolchain::Image image = read_program(options.source, options.include_directories, std::nullopt);
  for (const std::string& warning : image.warnings) fmt::print(stderr, "{}\n", warning);
  OutputFile output(options.output);
  std::optional<OutputFile> listing;
  if (options.listing) listing.emplace(*options.listing);
  toolchain::write_coff(image, output.working_path());
  if (listing) listing->stream() << toolchain::listing(image);
  output.commit();
  if (listing) listing->commit();
  return success;
}

int disassemble(const DisassembleOptions& options) {
  const toolchain::Image image = read_program(options.program, {}, options.load_at);
  const auto lookup = [&image](toolchain::Address address) { return symbol_at(image, address); };
  for (const auto& section : image.sections) {
    fmt::print("; section {}, {} words at {:08X}h{}\n", section.name, section.size, section.address,
               section.loaded ? "" : ", reserved");
    toolchain::Address address = section.address;
    for (const toolchain::Word word : section.words) {
      if (const std::string label = symbol_at(image, address); !label.empty()) fmt::print("{}:\n", label);
      fmt::print("{:08X}  {:08X}  {}\n", address, word, isa::disassemble(word, address, lookup));
      ++address;
    }
  }
  return success;
}

}  // namespace cli
