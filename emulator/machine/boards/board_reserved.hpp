#pragma once
/// Addresses without memory or devices: an access is a fault, or has no effect and is recorded (c40-hardware.md 1.1;
/// docs/boards.md).
#include <cstdint>
#include <string>
#include <vector>

#include "c40/chip/chip.hpp"
#include "c40/observers/probe.hpp"
#include "state/visitor.hpp"

namespace machine {

/// The addresses that the board leaves free, without 0 to FFFh, which belong to the boot ROM, and without `kept`.
std::vector<c40::AddressRange> unoccupied(const c40::Board& board, const std::vector<c40::AddressRange>& kept);

/// Makes windows of the ranges, split where the other bus begins.
void add_ignored(c40::Board& board, const std::vector<c40::AddressRange>& ranges);

/// A section for which a board has no RAM: names the nearest regions, and what would help.
std::string no_ram_for(const c40::Board& board, std::string_view section, c40::Address address, std::uint64_t words);

/// Answers accesses to such addresses, and records the first access to each.
class IgnoredAccesses {
 public:
  struct Note {
    c40::Address address = 0;
    bool write = false;  ///< of the first access, like the next four
    c40::Word value = 0;
    c40::Address pc = 0;
    c40::Cycles cycle = 0;
    int channel = -1;  ///< the DMA channel; -1: the processor
    std::uint64_t reads = 0, writes = 0;
    void list_state(state::Visitor& list);
  };

  explicit IgnoredAccesses(std::vector<c40::AddressRange> ranges) : ranges_(std::move(ranges)) {}

  /// Answers the access at which the chip stopped: a read gives 0, a write is lost, neither takes time of its own.
  /// False: the address is outside the ranges.
  bool serve(c40::Chip& chip, const c40::ExternalAccess& access);
  bool contains(c40::Address address) const;
  bool empty() const { return ranges_.empty(); }

  std::uint64_t count() const { return count_; }
  /// In the order of their first access; for this number of addresses at most.
  static constexpr std::size_t most_notes = 1000;
  const std::vector<Note>& notes() const { return notes_; }
  /// A line with the number of accesses, and a line for each address; empty if there were none.
  std::string text() const;

  void list_state(state::Visitor& list);

 private:
  std::vector<c40::AddressRange> ranges_;
  std::vector<Note> notes_;
  std::uint64_t count_ = 0;
};

}  // namespace machine
