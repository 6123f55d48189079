#include "c40/chip_file.hpp"

#include <fmt/format.h>

#include "state/archive.hpp"
#include "state/file.hpp"

namespace c40 {

namespace {

constexpr std::string_view kind = "processor";

}  // namespace

std::string key_of(const Board& board) {
  std::string key = fmt::format("flat {} peripherals {} GMICR {:08X}h LMICR {:08X}h ROM {} pins {} {:X}\n", board.is_flat, board.has_peripherals,
                                board.global_interface_control, board.local_interface_control, board.rom.size(), board.pins.reset_location, board.pins.iiof);
  for (const Region& r : board.regions)
    key += fmt::format("{:08X}h {:X}h {} {} {} {} {}\n", r.base, r.words, static_cast<int>(r.kind), static_cast<int>(r.bus), r.read_waits, r.write_waits, r.page_waits);
  return key;
}

std::string sealed(const Chip& chip) { return state::sealed(kind, {chip.board().name, key_of(chip.board()), state::save(chip)}); }

void restore(Chip& chip, std::string_view file) {
  const std::vector<std::string> parts = state::opened(file, kind, 3);
  if (parts[1] != key_of(chip.board()))
    throw state::StateError(fmt::format("the snapshot is of a chip on board {}; this one is on board {}, which differs", parts[0], chip.board().name));
  state::load_or_leave(chip, parts[2]);
}

}  // namespace c40
