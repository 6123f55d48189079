#pragma once
// Programs and numbers as arguments of a command line.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/arguments/options.hpp"
#include "io/file_roles.hpp"
#include "machine/boards/board_file.hpp"
#include "toolchain/objects/image.hpp"

namespace cli {

/// Reads a program; the suffix of the name decides how. .asm or .s: a source, assembled in `dialect`. .hex: one word
/// per line in hexadecimal, loaded at `load_at` (default 0). Anything else: a COFF file; an object is linked as
/// `emulator link` does without a map.
/// \throws InputError, toolchain::AssemblyError, toolchain::CoffError, toolchain::LinkError, and
/// toolchain::WrongProcessor for a program that is not for the C40.
toolchain::Image read_program(const std::string& path, const std::vector<std::string>& include_directories,
                              const std::optional<std::string>& load_at,
                              const std::optional<std::string>& dialect = {});
/// The same for a program that will not be run. `cpu` is the processor of a source or of words; a COFF file names it
/// itself.
toolchain::Image read_any_program(const std::string& path, const std::vector<std::string>& include_directories,
                                  const std::optional<std::string>& load_at, const std::optional<std::string>& dialect,
                                  const std::optional<std::string>& cpu);

/// Whether read_program() would assemble the file.
bool is_source_name(const std::string& path);

/// \throws InputError if there is no file that can be read.
void require_file(const std::string& path);

/// The board of that name for a run of exec, with the run's --memory-max. \throws InputError if --memory-max does not
/// apply to this board
machine::BoardDescription board_named(const ExecOptions& options, const std::string& name);
/// The files that exec reads: programs, boards, network. Files that the programs include are not among them.
io::FileRoles files_read(const ExecOptions& options);

/// Whether read_program() would take the file for a COFF file.
bool is_coff_name(const std::string& path);

/// "300000h", "0x300000", "3145728" or a symbol of the image. \throws InputError naming the option `what`.
toolchain::Address parse_address(std::string_view text, const toolchain::Image* image, std::string_view what);

/// CHIP:REST, or REST alone.
struct ChipText {
  std::optional<std::size_t> chip;
  std::string_view rest;  ///< of the text that was given
};
/// \throws InputError that names the option `what` for a chip that does not exist
ChipText chip_text(std::string_view text, std::size_t chips, std::string_view what);

}  // namespace cli
