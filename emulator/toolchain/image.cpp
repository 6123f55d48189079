#include "toolchain/image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace toolchain {

Word Image::symbol(std::string_view name) const {
  const auto found = symbols.find(name);
  if (found == symbols.end()) throw std::out_of_range(fmt::format("the program has no symbol '{}'", name));
  return found->second;
}

std::string listing(const Image& image) {
  std::string out;
  for (const Image::Section& section : image.sections) {
    out += fmt::format("section {} at {:08x}h, {} words{}\n", section.name, section.address, section.size,
                       section.loaded ? "" : ", not loaded");
    for (const LineRecord& line : image.lines) {
      const Address offset = line.address - section.address;
      if (line.section != static_cast<std::uint32_t>(&section - image.sections.data())) continue;
      const LineRecord* next = &line + 1;
      const bool is_last = next == image.lines.data() + image.lines.size() || next->section != line.section;
      const Address end = is_last ? section.size : next->address - section.address;
      out += fmt::format("{:08x} {:08x}  {:>5}  {}\n", line.address, section.words[offset], line.line, line.text);
      for (Address i = offset + 1; i < std::min(end, section.size); ++i)
        out += fmt::format("{:08x} {:08x}\n", section.address + i, section.words[i]);
    }
  }
  out += "symbols\n";
  for (const auto& [name, value] : image.symbols) out += fmt::format("{:08x} {}\n", value, name);
  return out;
}

}  // namespace toolchain
