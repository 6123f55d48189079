#pragma once
/// Boards and memory: regions are objects, so an access needs one subtraction and one comparison to know that it lies in the
/// region it met first. What the region's board asks for by RDY and what GMICR and LMICR say make the wait states.
///
/// Inaccuracies: a region answers on whichever strobe the registers give its addresses to.
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "c40/interface_control.hpp"
#include "c40/timing.hpp"
#include "c40/types.hpp"

namespace state {
class Visitor;
}

namespace c40 {

/// A part of the address space as a board declares it. On-chip RAM and the peripheral registers are the chip's own.
struct Region {
  enum class Kind : std::uint8_t { ram, rom, external_window, registers };
  enum class Bus : std::uint8_t { internal, local, global };
  std::string name;
  Address base = 0;
  std::uint64_t words = 0;
  int read_waits = 0;   ///< wait states that the board's RDY asks for, 0 to 15
  int write_waits = 0;  ///< 0 to 15
  Kind kind = Kind::ram;
  Bus bus = Bus::local;
  int page_waits = 0;  ///< what RDY asks for beyond them when PAGE says that the strobe's last access was in another page, 0 to 15
};

/// What surrounds one chip (rulings.md 26).
struct Board {
  std::string name;
  std::vector<Region> regions;
  bool is_flat = false;  ///< Plain zero-wait RAM without bus conflicts at every address that is none of a region or of the chip's own.
  /// Of such RAM a program may use so much, in pages of 64 K words. 256 MiB: it is the host's memory.
  std::uint64_t flat_words_max = std::uint64_t{1} << 26;
  bool has_peripherals = true;  ///< Their registers are at 100000h; else that is memory, or nothing.
  /// GMICR and LMICR as the board's boot header leaves them. The default: RDY alone on both strobes, no software wait states, pages
  /// of 1 K words on STRB0, which is the lower half.
  Word global_interface_control = 0x1DEA4000u;
  Word local_interface_control = 0x1DEA4000u;
  std::vector<Word> rom;  ///< The boot ROM's contents from address 0 on (ROMEN = 1); empty: it is not there.
  /// Pins that the board ties (c40-hardware.md 1.2).
  struct Pins {
    int reset_location = 0;  ///< RESETLOC(1,0): the reset vector stands at 0, 7FFFFFFFh, 80000000h or FFFFFFFFh
    Word iiof = 0;           ///< levels of IIOF3 to IIOF0 while nothing drives them: what a general-purpose input reads
  } pins;

  /// 300000h local SRAM 1 M words 0 wait, 40000000h local SRAM 1 M words 1 wait, 70000000h window to bus B, 80000000h
  /// global SRAM 1 M words 0 wait, C0000000h window to bus A.
  static Board default_board();
  /// RAM everywhere but for the chip's own RAM and peripheral registers (ruling 34).
  static Board flat();
  /// RAM everywhere, what single-step vectors run on: the chip has no peripherals there.
  static Board plain_ram();
};

inline constexpr Address on_chip_ram = 0x002FF800u;
inline constexpr Word on_chip_block_words = 0x400u;
inline constexpr Word rom_words = 0x1000u;
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
    Resource resource = Resource::ideal;
    int read_waits = 0, write_waits = 0, page_waits = 0;
    Word* data = nullptr;  ///< null unless RAM or ROM
    bool made = false;     ///< a page of a flat board

    bool contains(Address address) const { return address - base < words; }
    Word* code_map() const { return data + words; }
    void mark_code(Address address) const { code_map()[(address - base) >> 5] |= 1u << ((address - base) & 31); }
    void unmark_code(Address address) const { code_map()[(address - base) >> 5] &= ~(1u << ((address - base) & 31)); }
  };

  /// Pages that were last accessed, by bus and strobe: the PAGE pins.
  struct OpenPages {
    std::array<std::array<std::uint32_t, 2>, 2> page{};
    std::array<std::array<bool, 2>, 2> open{};
    friend bool operator==(const OpenPages&, const OpenPages&) = default;
  };
  /// What an address is met with: how it is accessed, and how far around it the same holds.
  struct Met {
    Access access;
    Address base = 0;
    Word words = 0;
    bool paged = false;  ///< The wait states depend on the page accessed before.
  };

  explicit Memory(const Board& board);

  /// GMICR and LMICR have these values from now on.
  void configure(Word global, Word local);
  /// `pages` matter to, and are changed by, accesses to a strobe where some region counts them.
  Met meet(const Area& area, Address address, bool write, OpenPages& pages) const;

  /// The area of an address, or null for a reserved one. On a flat board a page is made when it is first asked for; null where that would be
  /// more than the board's flat_words_max.
  const Area* find(Address address);
  const Area* find(Address address) const;
  const std::vector<std::unique_ptr<Area>>& areas() const { return areas_; }
  /// Contents page by page, those that are all 0 left out; of a flat board, which pages there are. No block may stand in them while they are set:
  /// areas go and come.
  void list_state(state::Visitor& list);

 private:
  struct Free {
    void operator()(Word* words) const;
  };
  const Area* add(Area area);
  const Area* make_flat_page(Address address);
  void set_flat_pages(const std::vector<Address>& bases);
  void note_paged();

  bool flat_;
  std::uint64_t flat_words_max_, flat_words_ = 0;
  std::array<InterfaceControl, 2> control_{};  // local, global
  std::array<std::array<bool, 2>, 2> paged_{};  // by bus and strobe: some region has page_waits
  std::vector<std::unique_ptr<Area>> areas_;  // by base
  std::vector<std::unique_ptr<Word, Free>> contents_;
};

}  // namespace c40
