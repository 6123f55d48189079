#pragma once
/// Memory: regions are objects, so one subtraction and one comparison tell whether an access is in the region of the
/// last access. The wait states follow from the board's RDY and from GMICR and LMICR.
///
/// Inaccuracies: a region answers on the strobe to which the registers assign its addresses, whichever that is.
#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "c40/chip/board.hpp"
#include "c40/memory/interface_control.hpp"
#include "c40/observers/probe.hpp"
#include "c40/pipeline/timing.hpp"
#include "c40/values/types.hpp"

namespace state {
class Visitor;
}

namespace c40 {

/// A region with its contents. After the last word, a bit map marks the words that belong to predecoded blocks.
class Memory {
 public:
  struct Area {
    std::string name;
    Address base = 0;
    Word words = 0;  ///< Whole address space: the pages of a flat board are made one by one.
    Region::Kind kind = Region::Kind::ram;
    Resource resource = Resource::ideal;
    int read_waits = 0, write_waits = 0, page_waits = 0;
    Word* data = nullptr;    ///< null unless RAM or ROM
    bool made = false;       ///< a page of a flat board
    bool set_apart = false;  ///< words of a probe: each access is resolved again
    bool piece = false;      ///< part of an area with words of a probe

    bool contains(Address address) const { return address - base < words; }
    Word* code_map() const { return data + words; }
    void mark_code(Address address) const { code_map()[(address - base) >> 5] |= 1u << ((address - base) & 31); }
    void unmark_code(Address address) const { code_map()[(address - base) >> 5] &= ~(1u << ((address - base) & 31)); }
  };

  /// The last accessed pages, by bus and strobe: the PAGE pins.
  struct OpenPages {
    std::array<std::array<std::uint32_t, 2>, 2> page{};
    std::array<std::array<bool, 2>, 2> open{};
    friend bool operator==(const OpenPages&, const OpenPages&) = default;
  };
  /// How an address is accessed, and how far around it the same holds.
  struct AccessInfo {
    Access access;
    Address base = 0;
    Word words = 0;
    bool paged = false;  ///< The wait states depend on the page of the access before.
  };

  explicit Memory(const Board& board);

  /// GMICR and LMICR get these values.
  void configure(Word global, Word local);
  /// `pages` matters only for strobes on which some region has page_waits; such accesses change it.
  AccessInfo meet(const Area& area, Address address, bool write, OpenPages& pages) const;

  /// The area of an address, or null for a reserved one. On a flat board a page is made on the first access; null if
  /// this would exceed the board's flat_words_max.
  const Area* find(Address address);
  const Area* find(Address address) const;
  const std::vector<std::unique_ptr<Area>>& areas() const { return areas_; }
  /// Puts exactly these words into areas of their own. Windows and marks of code from before become invalid.
  void set_apart(std::vector<AddressRange> ranges);
  /// Contents page by page, without the pages that are all 0; for a flat board also which pages exist. While the state
  /// is set no block may be in these areas: areas are created and deleted.
  void list_state(state::Visitor& list);

 private:
  static constexpr std::size_t mapped_from = 0x10000;  ///< bytes of an area that the system maps by itself
  static Word* new_contents(std::size_t bytes);
  struct Release {
    std::size_t bytes = 0;
    void operator()(Word* words) const;
  };
  const Area* add(Area area);
  const Area* make_flat_page(Address address);
  void set_flat_pages(const std::vector<Address>& bases);
  void note_paged();
  class Joined;
  void divide(const Area& area);
  void join();
  void gather() const;
  std::vector<const Area*> whole_areas() const;

  bool flat_;
  std::uint64_t flat_words_max_, flat_words_ = 0;
  std::array<InterfaceControl, 2> control_{};   // local, global
  std::array<std::array<bool, 2>, 2> paged_{};  // by bus and strobe: some region has page_waits
  std::vector<std::unique_ptr<Area>> areas_;    // by base
  std::vector<std::unique_ptr<Word, Release>> contents_;
  std::vector<AddressRange> apart_;
  std::vector<std::unique_ptr<Area>> divided_;  ///< areas whose contents are in pieces
};

}  // namespace c40
