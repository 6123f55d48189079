#include "toolchain/objects/object.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "toolchain/objects/coff.hpp"

namespace toolchain {

void check_overlaps(const Image& image, const std::string& file) {
  std::vector<const Image::Section*> loaded;
  for (const auto& section : image.sections)
    if (section.loaded && section.size != 0) loaded.push_back(&section);
  std::stable_sort(loaded.begin(), loaded.end(), [](auto* a, auto* b) { return a->address < b->address; });
  for (std::size_t i = 1; i < loaded.size(); ++i) {
    const auto &a = *loaded[i - 1], &b = *loaded[i];
    if (b.address - a.address < a.size)
      throw CoffError(fmt::format("{}: the sections {} ({} words at {:08X}h) and {} ({} words at {:08X}h) overlap",
                                  file, a.name, a.size, a.address, b.name, b.size, b.address));
  }
}

std::string name_for_relocations(const Object& object, int section, Word value) {
  const std::string base =
      section == ObjectSymbol::absolute ? "=" : object.sections[static_cast<std::size_t>(section)].name + "+";
  return fmt::format("{}{:X}h", base, value);
}

bool names_a_value(const Object& object, const ObjectSymbol& symbol) {
  return symbol.section != ObjectSymbol::undefined && !symbol.stands_for_section && !symbol.name.empty() &&
         (symbol.global || symbol.name != name_for_relocations(object, symbol.section, symbol.value));
}

std::size_t add_initial_values(Image& image, const std::string& table, const std::vector<Word>& records,
                               const std::string& file) {
  std::size_t at = 0;
  for (int number = 0; at < records.size() && records[at] != 0; ++number) {
    const std::size_t left = records.size() - at;
    const Word count = records[at];
    if (left < 2 || count > left - 2)
      throw CoffError(fmt::format("{}: record {} of {} asks for {} words, but {} are left", file, number, table, count,
                                  left < 2 ? 0 : left - 2));
    const auto begin = records.begin() + static_cast<std::ptrdiff_t>(at + 2);
    image.sections.push_back({.name = fmt::format("{}.{}", table, number),
                              .address = records[at + 1],
                              .size = count,
                              .words = {begin, begin + count},
                              .loaded = true,
                              .initial_values = true});
    at += 2 + count;
  }
  return at;
}

std::optional<RelocationType> relocation_type(std::uint16_t number) {
  const auto type = static_cast<RelocationType>(number);
  return name(type).empty() ? std::nullopt : std::optional(type);
}

std::string_view name(RelocationType type) {
  switch (type) {
    case RelocationType::rel24: return "R_REL24";
    case RelocationType::relword: return "R_RELWORD";
    case RelocationType::rellong: return "R_RELLONG";
    case RelocationType::pcrword: return "R_PCRWORD";
    case RelocationType::pcr24: return "R_PCR24";
    case RelocationType::partls16: return "R_PARTLS16";
    case RelocationType::partms16: return "R_PARTMS8";
  }
  return {};
}

unsigned width(RelocationType type) {
  switch (type) {
    case RelocationType::rellong: return 32;
    case RelocationType::rel24:
    case RelocationType::pcr24: return 24;
    default: return 16;
  }
}

bool is_relative(RelocationType type) { return type == RelocationType::pcrword || type == RelocationType::pcr24; }

Image image_of(const Object& executable) {
  Image image;
  image.cpu = executable.cpu;
  image.entry = executable.entry;
  image.files = executable.files;
  for (const ObjectSection& section : executable.sections) {
    if (section.size == 0) continue;
    image.sections.push_back({.name = section.name,
                              .address = section.address,
                              .size = section.size,
                              .words = section.loaded ? section.words : std::vector<Word>(),
                              .loaded = section.loaded});
    for (const ObjectLine& line : section.lines)
      image.lines.push_back({section.address + line.offset,
                             line.file,
                             line.line,
                             {},
                             static_cast<std::uint32_t>(image.sections.size() - 1),
                             {}});
    if (section.table_of_copies) add_initial_values(image, section.name, section.words, executable.name);
  }
  for (const bool global : {true, false})
    for (const ObjectSymbol& symbol : executable.symbols)
      if (symbol.global == global && symbol.section != ObjectSymbol::undefined && !symbol.stands_for_section &&
          !symbol.name.empty())
        image.add_symbol(symbol.name, symbol.value);
  check_overlaps(image, executable.name);
  if (image.sections.empty()) throw CoffError(fmt::format("{}: it has no sections", executable.name));
  return image;
}

}  // namespace toolchain
