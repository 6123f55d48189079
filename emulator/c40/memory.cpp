#include "c40/memory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <utility>

namespace c40 {
namespace {

constexpr Word flat_page_words = 0x10000u;

Resource resource_of(const Region& region) {
  switch (region.bus) {
    case Region::Bus::local: return Resource::local;
    case Region::Bus::global: return Resource::global;
    default: return Resource::ideal;
  }
}

Memory::Area area_of(const Region& region) {
  if (region.words == 0 || region.words > 0xFFFFFFFFull || region.base + (region.words - 1) > 0xFFFFFFFFull)
    throw std::invalid_argument(fmt::format("region {}: {} words at {:08X}h do not fit into the address space",
                                            region.name, region.words, region.base));
  for (int waits : {region.read_waits, region.write_waits})
    if (waits < 0 || waits > timing::max_region_waits)
      throw std::invalid_argument(fmt::format("region {}: {} wait states; 0 to {} are possible", region.name, waits,
                                              timing::max_region_waits));
  Memory::Area area;
  area.name = region.name;
  area.base = region.base;
  area.words = static_cast<Word>(region.words);
  area.kind = region.kind;
  area.read = {resource_of(region), static_cast<std::uint8_t>(region.read_waits), false};
  area.write = {resource_of(region), static_cast<std::uint8_t>(region.write_waits), true};
  return area;
}

Memory::Area on_chip(int block) {
  Memory::Area area;
  area.name = fmt::format("on-chip RAM block {}", block);
  area.base = on_chip_ram + static_cast<Word>(block) * on_chip_block_words;
  area.words = on_chip_block_words;
  const Resource resource = block == 0 ? Resource::ram0 : Resource::ram1;
  area.read = {resource, 0, false};
  area.write = {resource, 0, true};
  return area;
}

}  // namespace

Board Board::default_board() {
  using enum Region::Kind;
  using enum Region::Bus;
  Board board;
  board.name = "default";
  board.regions = {
      {"local SRAM", 0x00300000u, 0x100000u, 0, 0, ram, local},
      {"slow local SRAM", 0x40000000u, 0x100000u, 1, 1, ram, local},
      {"window to bus B", 0x70000000u, 0x10000000u, 0, 0, external_window, local},
      {"global SRAM", 0x80000000u, 0x100000u, 0, 0, ram, global},
      {"window to bus A", 0xC0000000u, 0x40000000u, 0, 0, external_window, global},
  };
  // Ready comes from the pin on both strobes, no software wait states, pages of 1 K words, STRB0 is the lower half.
  board.global_interface_control = 0x1DEA4000u;
  board.local_interface_control = 0x1DEA4000u;
  return board;
}

Board Board::flat() {
  Board board;
  board.name = "flat";
  board.is_flat = true;
  return board;
}

void Memory::Free::operator()(Word* words) const { std::free(words); }

Memory::Memory(const Board& board) : flat_(board.is_flat) {
  for (const Region& region : board.regions) add(area_of(region));
  add(on_chip(0));
  add(on_chip(1));
  if (!flat_) {
    Area registers;
    registers.name = "peripheral registers";
    registers.base = peripheral_base;
    registers.words = peripheral_words;
    registers.kind = Region::Kind::registers;
    registers.write.write = true;
    add(registers);
  }
}

const Memory::Area* Memory::add(Area area) {
  const auto place = std::find_if(areas_.begin(), areas_.end(), [&](const auto& a) { return a->base > area.base; });
  const std::uint64_t end = std::uint64_t{area.base} + area.words;
  const bool overlaps = (place != areas_.end() && (*place)->base < end) ||
                        (place != areas_.begin() && (*std::prev(place))->contains(area.base));
  if (overlaps) throw std::invalid_argument(fmt::format("region {} overlaps another one", area.name));
  if (area.kind == Region::Kind::ram) {
    // Fresh zero pages from the system: a large SRAM costs nothing until it is used.
    auto* data = static_cast<Word*>(std::calloc(std::size_t{area.words} + area.words / 32 + 1, sizeof(Word)));
    if (data == nullptr) throw std::bad_alloc();
    contents_.emplace_back(data);
    area.data = data;
  }
  return areas_.insert(place, std::make_unique<Area>(std::move(area)))->get();
}

// Pages of a flat board leave room for the on-chip RAM.
const Memory::Area* Memory::make_flat_page(Address address) {
  Area area;
  area.base = address & ~(flat_page_words - 1);
  area.words = flat_page_words;
  area.write.write = true;
  if (address >= area.base && area.base == (on_chip_ram & ~(flat_page_words - 1))) area.words = on_chip_ram - area.base;
  area.name = fmt::format("flat RAM {:08X}h", area.base);
  return add(area);
}

const Memory::Area* Memory::find(Address address) const {
  auto after = std::upper_bound(areas_.begin(), areas_.end(), address,
                                [](Address a, const auto& area) { return a < area->base; });
  if (after == areas_.begin() || !(*std::prev(after))->contains(address)) return nullptr;
  return std::prev(after)->get();
}

const Memory::Area* Memory::find(Address address) {
  const Area* area = std::as_const(*this).find(address);
  return area == nullptr && flat_ ? make_flat_page(address) : area;
}

}  // namespace c40
