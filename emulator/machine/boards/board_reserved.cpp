#include "machine/boards/board_reserved.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>

namespace machine {
namespace {

using c40::Address;
using c40::AddressRange;
using c40::Region;

constexpr std::uint64_t external_begin = 0x00300000u, global_begin = 0x80000000u, end_of_addresses = 1ull << 32;

struct Span {
  std::uint64_t begin, end;
};

Span span_of(const AddressRange& range) { return {range.first, std::uint64_t{range.first} + range.words}; }

Region::Bus bus_at(std::uint64_t address) {
  return address >= global_begin     ? Region::Bus::global
         : address >= external_begin ? Region::Bus::local
                                     : Region::Bus::internal;
}

/// Distance of the address from the region.
std::uint64_t distance(const Region& region, Address address) {
  const std::uint64_t end = std::uint64_t{region.base} + region.words;
  return address < region.base ? region.base - address : address < end ? 0 : address - (end - 1);
}

std::string extent(const Region& region) {
  return fmt::format("{}{} ({:08X}h to {:08X}h)", region.kind == Region::Kind::ram ? "" : "the window ", region.name,
                     region.base, region.base + region.words - 1);
}

}  // namespace

std::vector<AddressRange> unoccupied(const c40::Board& board, const std::vector<AddressRange>& kept) {
  std::vector<Span> taken{{0, c40::rom_words},
                          {c40::peripheral_base, std::uint64_t{c40::peripheral_base} + c40::peripheral_words},
                          {c40::on_chip_ram, external_begin}};
  for (const Region& region : board.regions) taken.push_back({region.base, std::uint64_t{region.base} + region.words});
  std::ranges::transform(kept, std::back_inserter(taken), span_of);
  taken.push_back({end_of_addresses, end_of_addresses});
  std::ranges::sort(taken, {}, &Span::begin);
  std::vector<AddressRange> out;
  std::uint64_t at = 0;
  for (const Span& next : taken) {
    if (next.begin > at) out.push_back({static_cast<Address>(at), static_cast<c40::Word>(next.begin - at)});
    at = std::max(at, next.end);
  }
  return out;
}

void add_ignored(c40::Board& board, const std::vector<AddressRange>& ranges) {
  for (const AddressRange& range : ranges) {
    const Span all = span_of(range);
    std::uint64_t at = all.begin;
    for (const std::uint64_t border : {external_begin, global_begin, all.end}) {
      const std::uint64_t end = std::min(border, all.end);
      if (end <= at) continue;
      Region region;
      region.name = fmt::format("nothing at {:08X}h", at);
      region.base = static_cast<Address>(at);
      region.words = end - at;
      region.kind = Region::Kind::external_window;
      region.bus = bus_at(at);
      board.regions.push_back(std::move(region));
      at = end;
    }
  }
}

std::string no_ram_for(const c40::Board& board, std::string_view section, Address address, std::uint64_t words) {
  std::vector<Region> regions = board.regions;
  std::erase_if(regions, [](const Region& region) { return region.name.starts_with("nothing at "); });
  regions.push_back({.name = "the chip's own RAM", .base = c40::on_chip_ram, .words = 2 * c40::on_chip_block_words});
  std::ranges::stable_sort(regions, {}, [&](const Region& region) { return distance(region, address); });
  regions.resize(std::min<std::size_t>(regions.size(), 2));
  std::vector<std::string> nearest;
  std::ranges::transform(regions, std::back_inserter(nearest), extent);
  return fmt::format(
      "section {} ({} words at {:08X}h) is not in RAM of board {}: nearest {} {}. A board file describes another "
      "board, with a [[region]] for these addresses (docs/boards.md)",
      section, words, address, board.name, nearest.size() == 1 ? "is" : "are", fmt::join(nearest, " and "));
}

bool IgnoredAccesses::contains(Address address) const {
  const auto holds = [&](const AddressRange& range) { return range.contains(address); };
  return std::ranges::any_of(ranges_, holds);
}

bool IgnoredAccesses::serve(c40::Chip& chip, const c40::ExternalAccess& access) {
  if (!contains(access.address)) return false;
  ++count_;
  auto note = std::ranges::find(notes_, access.address, &Note::address);
  if (note == notes_.end() && notes_.size() < most_notes)
    note = notes_.insert(notes_.end(), {.address = access.address,
                                        .write = access.write,
                                        .value = access.value,
                                        .pc = chip.pc(),
                                        .cycle = access.cycle,
                                        .channel = access.channel});
  if (note != notes_.end()) ++(access.write ? note->writes : note->reads);
  if (access.write)
    chip.complete_write(0, 0);
  else
    chip.complete_read(0, 0, 0);
  return true;
}

std::string IgnoredAccesses::text() const {
  if (count_ == 0) return {};
  std::string out = fmt::format("reserved addresses: {} access{}, ignored\n", count_, count_ == 1 ? "" : "es");
  std::uint64_t listed = 0;
  for (const Note& note : notes_) {
    listed += note.reads + note.writes;
    fmt::format_to(std::back_inserter(out), "  {:08X}h: {}{} at cycle {}, {}; {} reads, {} writes\n", note.address,
                   note.write ? fmt::format("write of {:08X}h", note.value) : "read",
                   note.channel < 0 ? fmt::format(" from PC {:08X}h", note.pc) : "", note.cycle,
                   note.channel < 0 ? "the first" : fmt::format("by DMA channel {}, the first", note.channel),
                   note.reads, note.writes);
  }
  if (listed < count_) out += fmt::format("  and {} accesses to other addresses\n", count_ - listed);
  return out;
}

void IgnoredAccesses::Note::list_state(state::Visitor& list) {
  list("address", address);
  list("write", write);
  list("value", value);
  list("pc", pc);
  list("cycle", cycle);
  list("channel", channel);
  list("reads", reads);
  list("writes", writes);
}

void IgnoredAccesses::list_state(state::Visitor& list) {
  list("notes", notes_);
  list("count", count_);
}

}  // namespace machine
