#pragma once
/// Boards and memory: regions are objects, so an access needs one subtraction and one comparison to know that it lies in the
/// region it met first.
///
/// Inaccuracies: the wait states are the region's; software wait states programmed into the memory interface control
/// registers have no effect. Address decoding by STRB ACTIVE is the board's, not the register's.
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "c40/timing.hpp"
#include "c40/types.hpp"

namespace c40 {

/// A part of the address space as a board declares it. On-chip RAM and the peripheral registers are the chip's own.
struct Region {
  enum class Kind : std::uint8_t { ram, external_window, registers };
  enum class Bus : std::uint8_t { internal, local, global };
  std::string name;
  Address base = 0;
  std::uint64_t words = 0;
  int read_waits = 0;   ///< 0 to 15
  int write_waits = 0;  ///< 0 to 15
  Kind kind = Kind::ram;
  Bus bus = Bus::local;
};

/// What surrounds one chip (rulings.md 26).
struct Board {
  std::string name;
  std::vector<Region> regions;
  bool is_flat = false;  ///< Plain zero-wait RAM at every address, without bus conflicts and without peripheral registers.
  Word global_interface_control = 0x3E39FFF0u;  ///< GMICR as the boot header leaves it.
  Word local_interface_control = 0x3E39FFF0u;

  /// 300000h local SRAM 1 M words 0 wait, 40000000h local SRAM 1 M words 1 wait, 70000000h window to bus B, 80000000h
  /// global SRAM 1 M words 0 wait, C0000000h window to bus A.
  static Board default_board();
  static Board flat();
};

inline constexpr Address on_chip_ram = 0x002FF800u;
inline constexpr Word on_chip_block_words = 0x400u;
inline constexpr Address peripheral_base = 0x00100000u;
inline constexpr Word peripheral_words = 0x100u;

/// A region with its contents. Behind the last word lies a bit map of the words that belong to predecoded blocks.
class Memory {
 public:
  struct Area {
    std::string name;
    Address base = 0;
    Word words = 0;  ///< Whole address space: flat areas are made page by page.
    Region::Kind kind = Region::Kind::ram;
    Access read, write;
    Word* data = nullptr;  ///< null unless RAM

    bool contains(Address address) const { return address - base < words; }
    Word* code_map() const { return data + words; }
    void mark_code(Address address) const { code_map()[(address - base) >> 5] |= 1u << ((address - base) & 31); }
    void unmark_code(Address address) const { code_map()[(address - base) >> 5] &= ~(1u << ((address - base) & 31)); }
  };

  explicit Memory(const Board& board);

  /// The area of an address, or null for a reserved one. On a flat board a page is made when it is first asked for.
  const Area* find(Address address);
  const Area* find(Address address) const;
  const std::vector<std::unique_ptr<Area>>& areas() const { return areas_; }

 private:
  struct Free {
    void operator()(Word* words) const;
  };
  const Area* add(Area area);
  const Area* make_flat_page(Address address);

  bool flat_;
  std::vector<std::unique_ptr<Area>> areas_;  // by base
  std::vector<std::unique_ptr<Word, Free>> contents_;
};

}  // namespace c40
