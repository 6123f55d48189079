#pragma once
/// Memory: regions are objects, so an access needs one subtraction and one comparison to know that it lies in the
/// region it met first. What the region's board asks for by RDY and what GMICR and LMICR say make the wait states.
///
/// Inaccuracies: a region answers on whichever strobe the registers give its addresses to.
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "c40/board.hpp"
#include "c40/interface_control.hpp"
#include "c40/probe.hpp"
#include "c40/timing.hpp"
#include "c40/types.hpp"

namespace state {
class Visitor;
}

namespace c40 {

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
    Word* data = nullptr;    ///< null unless RAM or ROM
    bool made = false;       ///< a page of a flat board
    bool set_apart = false;  ///< words of a probe: every access to them is looked up
    bool piece = false;      ///< of an area in which words are set apart

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
  struct AccessInfo {
    Access access;
    Address base = 0;
    Word words = 0;
    bool paged = false;  ///< The wait states depend on the page accessed before.
  };

  explicit Memory(const Board& board);

  /// GMICR and LMICR have these values from now on.
  void configure(Word global, Word local);
  /// `pages` matter to, and are changed by, accesses to a strobe where some region counts them.
  AccessInfo meet(const Area& area, Address address, bool write, OpenPages& pages) const;

  /// The area of an address, or null for a reserved one. On a flat board a page is made when it is first asked for;
  /// null where that would be more than the board's flat_words_max.
  const Area* find(Address address);
  const Area* find(Address address) const;
  const std::vector<std::unique_ptr<Area>>& areas() const { return areas_; }
  /// These words, and no others, stand in areas of their own from now on. No window, no mark of code may be kept from
  /// before.
  void set_apart(std::vector<AddressRange> ranges);
  /// Contents page by page, those that are all 0 left out; of a flat board, which pages there are. No block may stand
  /// in them while they are set: areas go and come.
  void list_state(state::Visitor& list);

 private:
  struct Free {
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
  std::vector<std::unique_ptr<Word, Free>> contents_;
  std::vector<AddressRange> apart_;
  std::vector<std::unique_ptr<Area>> divided_;  ///< areas whose contents stand in pieces
};

}  // namespace c40
