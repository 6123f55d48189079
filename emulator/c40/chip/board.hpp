#pragma once
/// The surroundings of a chip: regions of memory, windows to the outside, tied pins. c40::Memory has the contents.
#include <cstdint>
#include <string>
#include <vector>

#include "c40/values/types.hpp"

namespace c40 {

/// A part of the address space that a board declares. On-chip RAM and the peripheral registers belong to the chip.
struct Region {
  enum class Kind : std::uint8_t { ram, rom, external_window, registers };
  enum class Bus : std::uint8_t { internal, local, global };
  std::string name;
  Address base = 0;
  std::uint64_t words = 0;
  int read_waits = 0;   ///< wait states that the board requests with RDY, 0 to 15
  int write_waits = 0;  ///< 0 to 15
  Kind kind = Kind::ram;
  Bus bus = Bus::local;
  int page_waits =
      0;  ///< further wait states by RDY if PAGE says that the strobe's last access was in another page, 0 to 15
};

/// What surrounds one chip (ruling 26).
struct Board {
  std::string name;
  std::vector<Region> regions;
  bool is_flat = false;  ///< Plain zero-wait RAM without bus conflicts at every address outside the regions and the
                         ///< chip's own addresses.
  /// How much of such RAM a program may use, in pages of 64 K words. 256 MiB: this is memory of the host.
  std::uint64_t flat_words_max = std::uint64_t{1} << 26;
  bool has_peripherals = true;  ///< The peripheral registers are at 100000h; else memory or nothing is there.
  /// GMICR and LMICR as the board's boot header sets them. The default: RDY alone on both strobes, no software wait
  /// states, pages of 1 K words on STRB0, which is the lower half.
  Word global_interface_control = 0x1DEA4000u;
  Word local_interface_control = 0x1DEA4000u;
  std::vector<Word> rom;  ///< The boot ROM's contents from address 0 on (ROMEN = 1); empty: no boot ROM.
  /// Pins that the board ties (c40-hardware.md 1.2).
  struct Pins {
    int reset_location = 0;  ///< RESETLOC(1,0): the address of the reset vector, 0, 7FFFFFFFh, 80000000h or FFFFFFFFh
    Word iiof = 0;           ///< levels of IIOF3 to IIOF0 without a driver: what a general-purpose input reads
  } pins;

  /// 300000h local SRAM 1 M words 0 wait, 40000000h local SRAM 1 M words 1 wait, 70000000h window to bus B, 80000000h
  /// global SRAM 1 M words 0 wait, C0000000h window to bus A.
  static Board default_board();
  /// RAM everywhere except for the chip's own RAM and peripheral registers (ruling 34).
  static Board flat();
  /// RAM everywhere, for single-step vectors: here the chip has no peripherals.
  static Board plain_ram();
};

inline constexpr Address on_chip_ram = 0x002FF800u;
inline constexpr Word on_chip_block_words = 0x400u;
inline constexpr Word rom_words = 0x1000u;
inline constexpr Address peripheral_base = 0x00100000u;
inline constexpr Word peripheral_words = 0x100u;

}  // namespace c40
