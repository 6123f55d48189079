// emulator image: a program in the form of an EPROM, or of a stream for a port, from which a chip boots (docs/cli.md,
// Images).
#include <fmt/format.h>

#include "cli/arguments/options.hpp"
#include "cli/arguments/program.hpp"
#include "io/file_roles.hpp"
#include "io/output_file.hpp"
#include "io/print.hpp"
#include "machine/boards/board_file.hpp"
#include "machine/chips/boot.hpp"
#include "toolchain/objects/rom_file.hpp"

namespace cli {
namespace {

std::string text_of(const std::vector<isa::Word>& words) {
  std::string out;
  for (const isa::Word word : words) out += fmt::format("{:08X}\n", word);
  return out;
}

std::string contents(const ImageOptions& options, const toolchain::Image& program, const machine::BootHeader& header) {
  if (options.format == "boot-stream") return text_of(machine::boot_stream(program, header));
  std::vector<isa::Word> stream = machine::boot_memory(program, header);
  stream.front() = options.width;
  const auto format = options.format == "intel-hex" ? toolchain::RomFormat::intel_hex
                      : options.format == "srec"    ? toolchain::RomFormat::srec
                                                    : toolchain::RomFormat::binary;
  return toolchain::rom_file(toolchain::rom_bytes(stream), format);
}

}  // namespace

int image(const ImageOptions& options) {
  if (options.format == "boot-stream" && options.width != 32)
    throw InputError("--width: a port takes words of 32 bits; a memory may have 8 or 16");
  const machine::BoardDescription board = machine::read_board(options.board, machine::BoardFiles::leave);
  const toolchain::Image program = read_program(options.program, options.include_directories, {}, options.dialect);
  for (const std::string& warning : program.warnings) io::print(stderr, "{}\n", warning);
  io::FileRoles files;
  files.reads("the program", options.program).writes("-o", options.output);
  for (const std::string& source : program.files_read) files.reads("a source", source);
  machine::BootHeader header;
  header.global_interface_control = board.board.global_interface_control;
  header.local_interface_control = board.board.local_interface_control;
  io::OutputFile output(options.output);
  try {
    output.stream() << contents(options, program, header);
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("{}: {}", options.program, error.what()));
  }
  output.commit_or_note();
  return success;
}

}  // namespace cli
