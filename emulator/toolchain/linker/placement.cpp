#include "toolchain/linker/placement.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "isa/types.hpp"
#include "toolchain/objects/section_places.hpp"

namespace toolchain {
namespace {

constexpr std::uint64_t address_space = std::uint64_t{1} << 32;

std::string extent(const OutputSection& section) {
  return fmt::format("{} ({} words at {:08X}h)", section.name, section.size, section.address);
}

}  // namespace

void Placement::add(const ObjectSection& section, OutputSection::Source source) {
  OutputSection* out = find(section.name);
  if (out == nullptr) {
    sections_.push_back({.name = section.name, .parts = {}});
    out = &sections_.back();
  }
  const std::uint64_t offset = aligned(out->size, section.alignment);
  out->parts.push_back({source, static_cast<Address>(offset)});
  out->size = static_cast<Address>(std::min(offset + section.size, address_space - 1));
  out->alignment = std::max(out->alignment, section.alignment);
  out->blocked = out->blocked || section.blocked;
  out->loaded = out->loaded || section.loaded;
}

void Placement::need(const std::string& name) {
  if (find(name) == nullptr) sections_.push_back({.name = name, .parts = {}});
}

OutputSection* Placement::find(std::string_view name) {
  const auto found = std::find_if(sections_.begin(), sections_.end(), [&](const auto& s) { return s.name == name; });
  return found == sections_.end() ? nullptr : &*found;
}

const OutputSection* Placement::find(std::string_view name) const { return const_cast<Placement*>(this)->find(name); }

Address Placement::address_of(OutputSection::Source source) const { return addresses_.at(source); }

void Placement::place(const MemoryMap& map, isa::Cpu cpu, std::vector<std::string>& errors) {
  cpu_ = cpu;
  for (const auto& wanted : map.sections) {
    if (wanted.size != 0) need(wanted.section);
    OutputSection* section = find(wanted.section);
    if (section == nullptr) continue;
    section->size = std::max(section->size, wanted.size);
    section->alignment = std::max(section->alignment, wanted.alignment);
  }
  for (const OutputSection& section : sections_)
    if (section.loaded && section.size > largest_loaded_section)
      errors.push_back(fmt::format("section '{}' has {} words; {} are the most of a loaded section", section.name,
                                   section.size, largest_loaded_section));
  // TI's run-time library has a stack of 0 words and a heap of 1: its linker gives them their sizes.
  constexpr Address usual_words = 0x400;
  for (const std::string_view name : {".stack", ".sysmem"})
    if (OutputSection* section = find(name); section != nullptr && section->size <= 1) section->size = usual_words;
  std::vector<OutputSection*> rest;
  for (OutputSection& section : sections_)
    if (!section.for_loader) rest.push_back(&section);
  const auto take = [&](std::string_view name) -> OutputSection* {
    const auto at = std::find_if(rest.begin(), rest.end(), [&](auto* s) { return s->name == name; });
    if (at == rest.end()) return nullptr;
    OutputSection* section = *at;
    rest.erase(at);
    return section;
  };
  for (const auto& wanted : map.sections)
    if (wanted.address)
      if (OutputSection* section = take(wanted.section))
        put(*section, *wanted.address,
            wanted.memory.empty() ? map.memory_at(*wanted.address) : map.memory(wanted.memory), errors);
  for (const auto& wanted : map.sections)
    if (!wanted.address)
      if (OutputSection* section = take(wanted.section)) put_in(*section, *map.memory(wanted.memory), errors);
  std::stable_sort(rest.begin(), rest.end(), [](auto* a, auto* b) {
    return placement_rank(a->name, a->loaded) < placement_rank(b->name, b->loaded);
  });
  for (OutputSection* section : rest) put_in(*section, *map.memory(map.others), errors);
  placed_.clear();
  ends_.clear();
  std::stable_sort(sections_.begin(), sections_.end(),
                   [](const auto& a, const auto& b) { return a.address < b.address; });
  for (const OutputSection& section : sections_)
    for (const auto& part : section.parts) addresses_[part.source] = section.address + part.offset;
}

void Placement::check_end(const OutputSection& section, std::vector<std::string>& errors) const {
  if (std::uint64_t{section.address} + section.size > isa::address_space(cpu_))
    errors.push_back(fmt::format("section {} passes the end of the address space{}", extent(section),
                                 cpu_ == isa::Cpu::c3x ? " of the C3x, 0FFFFFFh" : ""));
}

void Placement::put(OutputSection& section, Address address, const MemoryMap::Memory* memory,
                    std::vector<std::string>& errors) {
  section.address = address;
  const std::uint64_t end = std::uint64_t{address} + section.size;
  if (address % section.alignment != 0)
    errors.push_back(fmt::format("section {} must be aligned to {} words", extent(section), section.alignment));
  check_end(section, errors);
  if (section.blocked && is_split(address, section.size))
    errors.push_back(fmt::format("section {} must lie in one page of 64 K words", extent(section)));
  if (memory != nullptr && (address < memory->origin || end > memory->origin + memory->length))
    errors.push_back(fmt::format("section {} does not lie in the memory '{}' ({} words at {:08X}h)", extent(section),
                                 memory->name, memory->length, memory->origin));
  for (const OutputSection* other : placed_)
    if (section.size != 0 && other->size != 0 && address < std::uint64_t{other->address} + other->size &&
        other->address < end)
      errors.push_back(fmt::format("the sections {} and {} overlap", extent(*other), extent(section)));
  placed_.push_back(&section);
}

void Placement::put_in(OutputSection& section, const MemoryMap::Memory& memory, std::vector<std::string>& errors) {
  std::vector<Extent> taken;
  for (const OutputSection* other : placed_) taken.push_back({other->address, other->size});
  std::uint64_t& end = ends_.try_emplace(&memory, memory.origin).first->second;
  const std::uint64_t last = memory.origin + memory.length;
  const auto place = [&](bool blocked) {
    return free_place(memory.origin, section.size, section.alignment, blocked, taken);
  };
  std::uint64_t at = aligned(end, section.alignment);
  if (section.size != 0) at = place(section.blocked || section.rather_in_one_page);
  if (at + section.size > last && section.rather_in_one_page && section.size != 0) at = place(section.blocked);
  section.address = static_cast<Address>(std::min(at, address_space - 1));
  if (section.size == 0) return;
  end = at + section.size;
  if (end > last) {
    errors.push_back(
        fmt::format("section '{}' of {} words does not fit in the memory '{}' ({} words at {:08X}h, {} left)",
                    section.name, section.size, memory.name, memory.length, memory.origin, at < last ? last - at : 0));
    return;  // No other section is moved to make room.
  }
  check_end(section, errors);
  placed_.push_back(&section);
}

}  // namespace toolchain
