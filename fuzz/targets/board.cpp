// Board files. A chip can be put on a board that is accepted, if the board is small.
#include "machine/boards/board_file.hpp"

#include "c40/chip/chip.hpp"
#include "fuzz/target.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 8192;
  constexpr std::uint64_t most_words = 1u << 16;
  if (size > most) return 0;
  static const fuzz::InputFile file("board.toml");
  fuzz::Input input(data, size);
  const std::string& path = file.write(input.text());
  machine::BoardDescription board;
  if (!fuzz::done<machine::BoardError>([&] { board = machine::read_board(path); })) return 0;
  std::uint64_t words = 0;
  for (const c40::Region& region : board.board.regions)
    if (region.kind != c40::Region::Kind::external_window) words += region.words;
  if (words > most_words) return 0;
  c40::Chip chip(board.board);
  chip.reset();
  chip.run_until(50);
  if (board.has_pins) fuzz::done<std::out_of_range>([&] { chip.boot(), chip.run_until(chip.cycle() + 50); });
  return 0;
}
