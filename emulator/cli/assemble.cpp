// emulator asm, emulator disasm, emulator trace-diff
#include <fmt/format.h>

#include <fstream>

#include "cli/options.hpp"
#include "cli/output_file.hpp"
#include "cli/program.hpp"
#include "isa/disassemble.hpp"
#include "report/trace_text.hpp"
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

int trace_diff(const TraceDiffOptions& options) {
  const auto open = [](const std::string& path) {
    std::ifstream in(path);
    if (!in) throw InputError(fmt::format("{}: no such file, or it cannot be read", path));
    return in;
  };
  std::ifstream left = open(options.left);
  std::ifstream right = open(options.right);
  std::optional<report::TraceDifference> difference;
  try {
    difference = report::compare_traces(left, right);
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("{} and {}: {}", options.left, options.right, error.what()));
  }
  if (!difference) {
    fmt::print("no difference\n");
    return success;
  }
  fmt::print("first difference: {}", difference->message());
  return run_failed;
}

}  // namespace cli
