// What a chip's memory holds when exec begins (exec_memory.hpp).
#include "cli/exec/exec_memory.hpp"

#include <fmt/format.h>

#include <span>

#include "cli/arguments/program.hpp"
#include "io/print.hpp"
#include "machine/boards/board_reserved.hpp"
#include "machine/chips/boot.hpp"
#include "toolchain/objects/rom_file.hpp"

namespace cli {

using toolchain::Address;
using toolchain::Image;
using toolchain::Word;

namespace {

void load(c40::Chip& chip, const Image& image, const c40::Board& board) {
  for (const Image::Section& section : image.sections) {
    if (!section.loaded) continue;
    try {
      chip.write_block(section.address, section.words);
    } catch (const std::out_of_range&) {
      throw InputError(machine::no_ram_for(board, section.name, section.address, section.size));
    }
  }
}

/// Puts the image where the chip will look for it: as a stream in the memory that the pins choose, or as it is, with a
/// reset vector of its own.
void place(c40::Chip& chip, const Image& image, const Boot& boot) {
  if (machine::reset_source(boot.board) == machine::ResetSource::vector) return load(chip, image, boot.board);
  const std::vector<Word> stream = stream_for(image, boot);
  try {
    machine::require_not_overwritten(stream, machine::boot_address(boot.board), image);
    chip.write_block(machine::boot_address(boot.board), stream);
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("--boot: {}", error.what()));
  } catch (const std::out_of_range& error) {
    throw InputError(fmt::format("--boot: the stream at {:08X}h does not lie in memory: {}",
                                 machine::boot_address(boot.board), error.what()));
  }
}

void write_words(c40::Chip& chip, Address address, std::span<const Word> words, std::string_view what) {
  try {
    chip.write_block(address, words);
  } catch (const std::out_of_range& error) {
    throw InputError(
        fmt::format("{}: {} words at {:08X}h do not lie in memory: {}", what, words.size(), address, error.what()));
  }
}

}  // namespace

void require_boot_for_roms(const ExecOptions& options) {
  if (!options.roms.empty() && !options.boot) throw InputError("--rom: needs --boot ADDRESS or --boot reset");
  if (options.rom_width && options.roms.empty()) throw InputError("--rom-width: needs --rom FILE@ADDRESS");
}

std::optional<Boot> parse_boot(const ExecOptions& options, const machine::BoardDescription& given) {
  if (!options.boot) return std::nullopt;
  const std::string& text = *options.boot;
  if (text == "reset") {
    if (!given.has_pins)
      throw InputError(
          fmt::format("--boot reset: board {} has no [pins]; a board file with [pins] is expected (docs/boards.md)",
                      given.board.name));
    if (machine::reset_source(given.board) == machine::ResetSource::ports)
      throw InputError(
          "--boot reset: the board's pins choose the communication ports; say through which the program comes: --boot "
          "0 to --boot 5");
    return Boot{given.board, {}};
  }
  Boot boot;
  try {
    if (text.size() == 1 && text[0] >= '0' && text[0] <= '5') {
      boot.port = text[0] - '0';
      boot.board = machine::with_boot_from_port(given.board);
    } else {
      boot.board = machine::with_boot_from_memory(given.board, parse_address(text, nullptr, "--boot"));
    }
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("--boot: {}", error.what()));
  }
  const auto& asked = boot.board.pins;
  const auto& tied = given.board.pins;
  if (given.has_pins &&
      (given.board.rom.empty() || asked.reset_location != tied.reset_location || asked.iiof != tied.iiof))
    throw InputError(
        fmt::format("--boot {}: needs [pins] of board {} with romen = true, resetloc = 0, iiof = \"{:04b}\"; "
                    "--boot reset starts with the board's own pins",
                    text, given.board.name, asked.iiof));
  return boot;
}

std::vector<Word> stream_for(const Image& image, const Boot& boot) {
  machine::BootHeader header;
  header.global_interface_control = boot.board.global_interface_control;
  header.local_interface_control = boot.board.local_interface_control;
  try {
    return boot.port ? machine::boot_stream(image, header) : machine::boot_memory(image, header);
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("--boot: {}", error.what()));
  }
}

std::pair<std::string, Address> file_at(const std::string& text, std::string_view what, const Image* image) {
  const std::size_t at = text.rfind('@');
  if (at == std::string::npos || at == 0) throw InputError(fmt::format("{}: \"{}\" is not FILE@ADDRESS", what, text));
  return {text.substr(0, at), parse_address(std::string_view(text).substr(at + 1), image, what)};
}

std::vector<machine::BoardDescription::Contents> rom_contents(const ExecOptions& options, const Image* image) {
  struct Placed {
    std::uint64_t begin, end;
    std::string file;
  };
  std::vector<Placed> placed;
  std::vector<machine::BoardDescription::Contents> contents;
  for (const std::string& given : options.roms) {
    const auto [file, address] = file_at(given, "--rom", image);
    const auto bytes = toolchain::read_rom(file);  // once: a FIFO can be read once only
    std::vector<Word> words = toolchain::rom_words_of(file, bytes, options.rom_width, "--rom-width");
    if (const std::string warning = toolchain::width_contradiction(bytes, options.rom_width, "--rom-width");
        !warning.empty())
      io::print(stderr, "--rom {}: warning: {}\n", file, warning);
    const Placed here{address, address + std::uint64_t{words.size()}, file};
    for (const Placed& other : placed)
      if (here.begin < other.end && other.begin < here.end)
        throw InputError(fmt::format("--rom {}: its words {:08X}h to {:08X}h overlap those of {}, {:08X}h to {:08X}h",
                                     file, here.begin, here.end - 1, other.file, other.begin, other.end - 1));
    placed.push_back(here);
    contents.push_back({address, std::move(words)});
  }
  return contents;
}

bool boots_rom(const ExecOptions& options, const machine::BoardDescription& board) {
  return !options.roms.empty() || (!board.contents.empty() && options.boot);
}

void prepare(c40::Chip& chip, const ExecOptions& options, const Image& image, const machine::BoardDescription& board,
             const std::optional<Boot>& boot) {
  for (const auto& [base, words] : board.contents) write_words(chip, base, words, "board " + board.board.name);
  if (!boot) {
    chip.reset();
    load(chip, image, board.board);
    place_additions(chip, options.loads, options.pokes, &image);
    chip.set_pc(options.entry ? parse_address(*options.entry, &image, "--entry") : image.entry);
    return;
  }
  if (boots_rom(options, board) && !boot->port)
    for (const auto& [base, words] : rom_contents(options, &image)) write_words(chip, base, words, "--rom");
  else if (!options.roms.empty())
    throw InputError(
        "--rom: with --boot PORT the chip gets its program through the port; --boot ADDRESS or reset is expected");
  else if (!boot->port)
    place(chip, image, *boot);
  place_additions(chip, options.loads, options.pokes, &image);  // they may be the reset vector
  try {
    chip.boot();
  } catch (const std::out_of_range& error) {
    throw InputError(fmt::format("--boot {}: {}", *options.boot, error.what()));
  }
}

void place_additions(c40::Chip& chip, std::span<const std::string> loads, std::span<const std::string> pokes,
                     const Image* image) {
  for (const std::string& given : loads) {
    const auto [file, address] = file_at(given, "--load", image);
    write_words(chip, address, toolchain::read_rom_words(file, 32, "--load"), "--load " + file);
  }
  for (const std::string& given : pokes) {
    const std::size_t equals = given.find('=');
    if (equals == std::string::npos) throw InputError(fmt::format("--poke: \"{}\" is not ADDRESS=WORD", given));
    const Word word = parse_address(std::string_view(given).substr(equals + 1), image, "--poke, behind =");
    write_words(chip, parse_address(std::string_view(given).substr(0, equals), image, "--poke"), std::span(&word, 1),
                "--poke");
  }
}

}  // namespace cli
