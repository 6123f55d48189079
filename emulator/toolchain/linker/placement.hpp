#pragma once
// Where the linker puts the objects' sections.
#include <compare>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "toolchain/linker/memory_map.hpp"
#include "toolchain/objects/object.hpp"

namespace toolchain {

/// A section of the program: the sections of that name of all objects, one after the other.
struct OutputSection {
  struct Source {
    std::size_t object = 0, section = 0;
    auto operator<=>(const Source&) const = default;
  };
  struct Part {
    Source source;
    Address offset = 0;
  };

  std::string name;
  Address address = 0;
  Address size = 0;
  Address alignment = 1;
  bool blocked = false;
  bool rather_in_one_page = false;  ///< As if blocked, where its memory has room for that.
  bool loaded = false;
  bool for_loader = false;  ///< Only for the loader: takes no memory and has the address 0.
  std::vector<Part> parts;
};

class Placement {
 public:
  void add(const ObjectSection& section, OutputSection::Source source);

  /// A section of this name is there, even if no object has one.
  void need(const std::string& name);

  /// Assigns the addresses. Sections with an address in the map come first, then the other sections of the map in its
  /// order, then .text, .data, other loaded ones, .bss, other reserved ones, each at the first free place of its
  /// memory. An empty section lies behind the one that was placed in its memory before it.
  void place(const MemoryMap& map, isa::Cpu cpu, std::vector<std::string>& errors);

  const std::vector<OutputSection>& sections() const { return sections_; }  ///< By rising address after placement.
  OutputSection* find(std::string_view name);
  const OutputSection* find(std::string_view name) const;
  Address address_of(OutputSection::Source source) const;

 private:
  void put(OutputSection& section, Address address, const MemoryMap::Memory* memory, std::vector<std::string>& errors);
  void check_end(const OutputSection& section, std::vector<std::string>& errors) const;
  void put_in(OutputSection& section, const MemoryMap::Memory& memory, std::vector<std::string>& errors);

  std::vector<OutputSection> sections_;
  std::vector<const OutputSection*> placed_;
  std::map<const MemoryMap::Memory*, std::uint64_t> ends_;  ///< Of the section that was placed last in each memory.
  isa::Cpu cpu_ = isa::Cpu::c40;
  std::map<OutputSection::Source, Address> addresses_;
};

}  // namespace toolchain
