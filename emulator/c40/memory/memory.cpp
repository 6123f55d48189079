#include "c40/memory/memory.hpp"

#include <fmt/format.h>
#include <sys/mman.h>

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

constexpr std::size_t bus_index(Resource r) { return r == Resource::global; }
constexpr std::uint64_t range_begin(std::size_t bus) { return bus == 1 ? 0x80000000u : 0u; }

Memory::Area area_of(const Region& region) {
  if (region.words == 0 || region.words > 0xFFFFFFFFull || region.base + (region.words - 1) > 0xFFFFFFFFull)
    throw std::invalid_argument(fmt::format("region {}: {} words at {:08X}h do not fit into the address space",
                                            region.name, region.words, region.base));
  for (int waits : {region.read_waits, region.write_waits, region.page_waits})
    if (waits < 0 || waits > timing::max_region_waits)
      throw std::invalid_argument(
          fmt::format("region {}: {} wait states; 0 to {} are possible", region.name, waits, timing::max_region_waits));
  Memory::Area area;
  area.name = region.name;
  area.base = region.base;
  area.words = static_cast<Word>(region.words);
  area.kind = region.kind;
  area.resource = resource_of(region);
  area.read_waits = region.read_waits;
  area.write_waits = region.write_waits;
  area.page_waits = region.page_waits;
  return area;
}

Memory::Area on_chip(int block) {
  Memory::Area area;
  area.name = fmt::format("on-chip RAM block {}", block);
  area.base = on_chip_ram + static_cast<Word>(block) * on_chip_block_words;
  area.words = on_chip_block_words;
  area.resource = block == 0 ? Resource::ram0 : Resource::ram1;
  return area;
}

Memory::Area boot_rom() {
  Memory::Area area;
  area.name = "boot ROM";
  area.words = rom_words;
  area.kind = Region::Kind::rom;
  area.resource = Resource::rom;
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
  return board;
}

Board Board::flat() {
  Board board;
  board.name = "flat";
  board.is_flat = true;
  return board;
}

Board Board::plain_ram() {
  Board board = flat();
  board.name = "plain RAM";
  board.has_peripherals = false;
  return board;
}

// The system gives zero pages on demand: a large SRAM costs nothing until it is used. calloc does so only as long as no
// SRAM has been freed: then it takes the freed one and writes zeros. For a small area that is cheaper than two calls of
// the system and its page faults.
Word* Memory::new_contents(std::size_t bytes) {
  void* const made = bytes < mapped_from
                         ? std::calloc(1, bytes)
                         : mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (made == nullptr || made == MAP_FAILED) throw std::bad_alloc();
  return static_cast<Word*>(made);
}

void Memory::Release::operator()(Word* words) const {
  if (bytes < mapped_from)
    std::free(words);
  else
    munmap(words, bytes);
}

Memory::Memory(const Board& board) : flat_(board.is_flat), flat_words_max_(board.flat_words_max) {
  for (const Region& region : board.regions) add(area_of(region));
  add(on_chip(0));
  add(on_chip(1));
  if (board.rom.size() > rom_words)
    throw std::invalid_argument(fmt::format("the boot ROM has {} words, not {}", rom_words, board.rom.size()));
  if (!board.rom.empty()) std::ranges::copy(board.rom, add(boot_rom())->data);
  if (board.has_peripherals) {
    Area registers;
    registers.name = "peripheral registers";
    registers.base = peripheral_base;
    registers.words = peripheral_words;
    registers.kind = Region::Kind::registers;
    registers.resource = Resource::peripheral;
    add(registers);
  }
  configure(board.global_interface_control, board.local_interface_control);
}

void Memory::configure(Word global, Word local) {
  control_ = {InterfaceControl::decode(local), InterfaceControl::decode(global)};
  note_paged();
}

void Memory::note_paged() {
  for (std::size_t b = 0; b < 2; ++b)
    for (std::size_t s = 0; s < 2; ++s) {
      const std::uint64_t start = range_begin(b), split = start + control_[b].strobe0_words;
      paged_[b][s] = std::ranges::any_of(areas_, [&](const auto& area) {
        const std::uint64_t end = std::uint64_t{area->base} + area->words;
        return area->page_waits != 0 && external(area->resource) && bus_index(area->resource) == b &&
               (s == 0 ? area->base < split : end > split);
      });
    }
}

Memory::AccessInfo Memory::meet(const Area& area, Address address, bool write, OpenPages& pages) const {
  AccessInfo met{{area.resource, static_cast<std::uint8_t>(write ? area.write_waits : area.read_waits), write, false},
                 area.base,
                 area.words,
                 false};
  if (!external(area.resource)) return met;
  const std::size_t b = bus_index(area.resource);
  const InterfaceControl& control = control_[b];
  const std::uint64_t split = range_begin(b) + control.strobe0_words, end = std::uint64_t{area.base} + area.words;
  const unsigned strobe = address >= split ? 1 : 0;
  if (area.base < split && split < end) {
    if (strobe == 1) met.base = static_cast<Address>(split);
    met.words = static_cast<Word>(strobe == 1 ? end - split : split - area.base);
  }
  int outside = met.access.waits;
  if (paged_[b][strobe]) {
    met.paged = true;
    const Word page = address >> control.strobe[strobe].page_bits;
    if (!pages.open[b][strobe] || pages.page[b][strobe] != page) outside += area.page_waits;
    pages.open[b][strobe] = true;
    pages.page[b][strobe] = page;
  }
  met.access.waits = static_cast<std::uint8_t>(control.waits(strobe, outside));
  met.access.strobe1 = control.strobe_switch && strobe == 1;
  return met;
}

const Memory::Area* Memory::add(Area area) {
  const auto place = std::find_if(areas_.begin(), areas_.end(), [&](const auto& a) { return a->base > area.base; });
  const std::uint64_t end = std::uint64_t{area.base} + area.words;
  const bool overlaps = (place != areas_.end() && (*place)->base < end) ||
                        (place != areas_.begin() && (*std::prev(place))->contains(area.base));
  if (overlaps) throw std::invalid_argument(fmt::format("region {} overlaps another one", area.name));
  if (area.kind == Region::Kind::ram || area.kind == Region::Kind::rom) {
    const std::size_t bytes = (std::size_t{area.words} + area.words / 32 + 1) * sizeof(Word);
    area.data = new_contents(bytes);
    contents_.emplace_back(area.data, Release{bytes});
  }
  return areas_.insert(place, std::make_unique<Area>(std::move(area)))->get();
}

// Pages of a flat board leave out what is already there: on-chip RAM, peripheral registers.
const Memory::Area* Memory::make_flat_page(Address address) {
  Area area;
  area.base = address & ~(flat_page_words - 1);
  Address end = area.base + (flat_page_words - 1);  // its last word
  for (const auto& other : areas_) {
    const Address last = other->base + (other->words - 1);
    if (last < address) area.base = std::max(area.base, last + 1);
    if (other->base > address) end = std::min(end, other->base - 1);
  }
  area.words = end - area.base + 1;
  if (flat_words_ + area.words > flat_words_max_) return nullptr;
  flat_words_ += area.words;
  area.name = fmt::format("flat RAM {:08X}h", area.base);
  area.made = true;
  const Area* page = add(area);
  if (apart_.empty()) return page;
  divide(*page);
  return std::as_const(*this).find(address);
}

// ---- areas with words of a probe ----

namespace {

/// Where the parts of [base, base + words) begin; each part is inside one range or outside all.
std::vector<std::uint64_t> borders(const Memory::Area& area, const std::vector<AddressRange>& ranges) {
  const std::uint64_t begin = area.base, end = begin + area.words;
  std::vector<std::uint64_t> places{begin};
  for (const AddressRange& range : ranges)
    for (const std::uint64_t place : {std::uint64_t{range.first}, std::uint64_t{range.first} + range.words})
      if (place > begin && place < end) places.push_back(place);
  std::ranges::sort(places);
  places.erase(std::unique(places.begin(), places.end()), places.end());
  places.push_back(end);
  return places;
}

bool in_any(Address address, const std::vector<AddressRange>& ranges) {
  return std::ranges::any_of(ranges, [&](const AddressRange& range) { return range.contains(address); });
}

}  // namespace

void Memory::set_apart(std::vector<AddressRange> ranges) {
  join();
  apart_ = std::move(ranges);
  std::vector<const Area*> whole;
  for (const auto& area : areas_) whole.push_back(area.get());
  for (const Area* area : whole) divide(*area);
}

void Memory::divide(const Area& area) {
  if (area.data == nullptr) return;
  const std::vector<std::uint64_t> places = borders(area, apart_);
  if (places.size() == 2 && !in_any(area.base, apart_)) return;
  const auto own = std::ranges::find_if(areas_, [&](const auto& a) { return a.get() == &area; });
  divided_.push_back(std::move(*own));
  areas_.erase(own);
  const Area& whole = *divided_.back();
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {
    Area piece = whole;
    piece.base = static_cast<Address>(places[i]);
    piece.words = static_cast<Word>(places[i + 1] - places[i]);
    piece.piece = true;
    piece.set_apart = in_any(piece.base, apart_);
    const Area* made = add(std::move(piece));
    std::copy_n(whole.data + (made->base - whole.base), made->words, made->data);
  }
}

// Copies the contents of the pieces back into the whole areas.
void Memory::gather() const {
  for (const auto& whole : divided_)
    for (const auto& piece : areas_)
      if (piece->piece && whole->contains(piece->base))
        std::copy_n(piece->data, piece->words, whole->data + (piece->base - whole->base));
}

void Memory::join() {
  gather();
  std::erase_if(contents_, [&](const auto& words) {
    return std::ranges::any_of(areas_, [&](const auto& area) { return area->piece && area->data == words.get(); });
  });
  std::erase_if(areas_, [](const auto& area) { return area->piece; });
  for (auto& whole : divided_) {
    const auto place = std::ranges::find_if(areas_, [&](const auto& a) { return a->base > whole->base; });
    areas_.insert(place, std::move(whole));
  }
  divided_.clear();
}

std::vector<const Memory::Area*> Memory::whole_areas() const {
  std::vector<const Area*> all;
  for (const auto& area : areas_)
    if (!area->piece) all.push_back(area.get());
  for (const auto& area : divided_) all.push_back(area.get());
  std::ranges::sort(all, {}, &Area::base);
  return all;
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
