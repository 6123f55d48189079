// Board files. A chip can be put on a board that is accepted, if the board is small, and a program can touch its
// devices.
#include "machine/boards/board_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>

#include "c40/chip/chip.hpp"
#include "fuzz/target.hpp"
#include "machine/networks/network.hpp"
#include "toolchain/assembler/assembler.hpp"

namespace {

/// The program writes and reads the first words of the board's first devices.
std::shared_ptr<const toolchain::Image> touching(const machine::BoardDescription& board) {
  constexpr std::size_t few_devices = 4, few_words = 6;
  std::string source = "        .text\nstart:  ldi 5,r0\n";
  for (std::size_t n = 0; n < std::min(few_devices, board.devices.size()); ++n) {
    const c40::Address base = board.devices[n].base;
    source += fmt::format("        ldhi 0{:x}h,ar0\n        or 0{:x}h,ar0\n", base >> 16, base & 0xFFFF);
    for (std::size_t word = 0; word < few_words; ++word)
      source += fmt::format("        sti r0,*+ar0({})\n        ldi *+ar0({}),r1\n", word, word);
  }
  source += "end:    b end\n";
  return std::make_shared<toolchain::Image>(toolchain::assemble_text(source, "touching.asm"));
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 8192;
  constexpr std::uint64_t most_words = 1u << 16;
  if (size > most) return 0;
  static const fuzz::InputFile file("board.toml", {{"words.txt", "12 34\n"},
                                                   {"host.txt", "at 10 65\nwait 20 66\n"},
                                                   {"boot.hex", ":0400000008000000F4\n:00000001FF\n"}});
  fuzz::Input input(data, size);
  const std::string& path = file.write(input.text());
  machine::BoardDescription board;
  if (!fuzz::done<machine::BoardError>([&] { board = machine::read_board(path); })) return 0;
  std::uint64_t words = 0;
  for (const c40::Region& region : board.board.regions)
    if (region.kind != c40::Region::Kind::external_window) words += region.words;
  if (words > most_words) return 0;
  {
    c40::Chip chip(board.board);
    chip.reset();
    chip.run_until(50);
    if (board.has_pins) fuzz::done<std::out_of_range>([&] { chip.boot(), chip.run_until(chip.cycle() + 50); });
  }
  machine::NetworkDescription network;
  machine::NetworkChip chip;
  chip.program = touching(board);
  chip.board = board;
  network.chips.push_back(std::move(chip));
  fuzz::done<machine::NetworkError, machine::BoardError>([&] {
    machine::Network made(network);
    made.run_until(machine::Time{5'000'000});
    made.check_words();
    made.describe(0);
  });
  return 0;
}
