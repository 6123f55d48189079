#pragma once
/// Addresses at which a board has nothing: a fault, or an access that does nothing and is noted (c40-hardware.md 1.1;
/// docs/boards.md).
#include <cstdint>
#include <string>
#include <vector>

#include "c40/chip.hpp"
#include "c40/probe.hpp"
#include "state/visitor.hpp"

namespace machine {

/// What the board leaves to nobody, without 0 to FFFh, which are the boot ROM's, and without `kept`.
std::vector<c40::AddressRange> unoccupied(const c40::Board& board, const std::vector<c40::AddressRange>& kept);

/// Makes windows of the ranges, split where another bus begins.
void add_ignored(c40::Board& board, const std::vector<c40::AddressRange>& ranges);

/// A section that a board has no RAM for: what it has nearest, and what would help.
std::string no_ram_for(const c40::Board& board, std::string_view section, c40::Address address, std::uint64_t words);

/// Answers the accesses to such ranges and keeps the first one to each address.
class IgnoredAccesses {
 public:
  struct Note {
    c40::Address address = 0;
    bool write = false;  ///< of the first access, as are the next four
    c40::Word value = 0;
    c40::Address pc = 0;
    c40::Cycles cycle = 0;
    int channel = -1;  ///< of the DMA; -1: the processor
    std::uint64_t reads = 0, writes = 0;
    void list_state(state::Visitor& list);
  };

  explicit IgnoredAccesses(std::vector<c40::AddressRange> ranges) : ranges_(std::move(ranges)) {}

  /// Answers the access at which the chip has stopped: a read gives 0, a write is lost, neither takes time of its own.
  /// false: the address is none of the ranges'.
  bool serve(c40::Chip& chip, const c40::ExternalAccess& access);
  bool contains(c40::Address address) const;
  bool empty() const { return ranges_.empty(); }

  std::uint64_t count() const { return count_; }
  /// In the order of their first access; of so many addresses.
  static constexpr std::size_t most_notes = 1000;
  const std::vector<Note>& notes() const { return notes_; }
  /// A line with the number of accesses, and one for each address; nothing if there was none.
  std::string text() const;

  void list_state(state::Visitor& list);

 private:
  std::vector<c40::AddressRange> ranges_;
  std::vector<Note> notes_;
  std::uint64_t count_ = 0;
};

}  // namespace machine
