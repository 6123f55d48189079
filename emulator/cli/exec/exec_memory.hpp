#pragma once
// What a chip's memory holds when exec begins: the program, a boot stream, ROMs, --load and --poke.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "c40/chip/chip.hpp"
#include "cli/arguments/options.hpp"
#include "machine/boards/board_file.hpp"
#include "toolchain/objects/image.hpp"

namespace cli {

/// Start from reset, with the board's pins.
struct Boot {
  c40::Board board;
  std::optional<int> port;  ///< that gives the program
};

/// That --rom stands with --boot, and --rom-width with --rom. \throws InputError
void require_boot_for_roms(const ExecOptions& options);
/// --boot PORT, ADDRESS or reset. \throws InputError
std::optional<Boot> parse_boot(const ExecOptions& options, const machine::BoardDescription& given);
/// The stream that a boot loader takes from a port or finds in memory. \throws InputError
std::vector<toolchain::Word> stream_for(const toolchain::Image& image, const Boot& boot);

/// FILE@ADDRESS as a value of the option `what`. \throws InputError
std::pair<std::string, toolchain::Address> file_at(const std::string& text, std::string_view what,
                                                   const toolchain::Image* image);

/// What the ROMs of --rom hold, as it is; what of it is booted is for the pins to say. \throws InputError where two
/// overlap
std::vector<machine::BoardDescription::Contents> rom_contents(const ExecOptions& options,
                                                              const toolchain::Image* image);
/// Whether a ROM is booted: one that is given, or one of the board's.
bool boots_rom(const ExecOptions& options, const machine::BoardDescription& board);
/// Fills the memories, with --load and --poke last, and puts the chip before its first instruction. \throws InputError
void prepare(c40::Chip& chip, const ExecOptions& options, const toolchain::Image& image,
             const machine::BoardDescription& board, const std::optional<Boot>& boot);
/// Does --load and --poke, in this order. \throws InputError
void place_additions(c40::Chip& chip, std::span<const std::string> loads, std::span<const std::string> pokes,
                     const toolchain::Image* image);

}  // namespace cli
