#include "toolchain/objects/image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <vector>

#include "io/nearest.hpp"
#include "io/print.hpp"
#include "isa/types.hpp"
#include "toolchain/objects/missing_symbol.hpp"
#include "toolchain/objects/written_integer.hpp"

namespace toolchain {

Word Image::symbol(std::string_view name) const {
  const auto found = symbols.find(name);
  if (found == symbols.end()) throw MissingSymbol(fmt::format("the program has no symbol '{}'", name));
  return found->second;
}

void Image::add_symbol(const std::string& name, Word value) {
  const auto [first, fresh] = symbols.insert({name, value});
  if (fresh || first->second == value) return;
  const auto [begin, end] = further_symbols.equal_range(name);
  if (std::none_of(begin, end, [&](const auto& other) { return other.second == value; }))
    further_symbols.insert({name, value});
}

std::vector<std::pair<std::string_view, Word>> Image::names() const {
  std::vector<std::pair<std::string_view, Word>> out;
  std::merge(symbols.begin(), symbols.end(), further_symbols.begin(), further_symbols.end(), std::back_inserter(out),
             [](const auto& a, const auto& b) { return a.first < b.first; });
  return out;
}

Word* Image::word_at(Address address) {
  for (Section& section : sections)
    if (section.loaded && address - section.address < section.words.size())
      return &section.words[address - section.address];
  return nullptr;
}

std::optional<Address> find_address(std::string_view text, const Image* image) {
  if (image != nullptr)
    if (const auto symbol = image->symbols.find(text); symbol != image->symbols.end()) return symbol->second;
  const auto value = written_integer(text);
  return value && *value <= 0xFFFF'FFFF ? std::optional(static_cast<Address>(*value)) : std::nullopt;
}

std::string no_address(std::string_view text, const Image* image) {
  if (image == nullptr)
    return fmt::format(
        "\"{}\" cannot be used; a number from 0 to 0FFFFFFFFh is expected (300000h, 0x300000 or decimal)", text);
  std::vector<std::string_view> symbols;
  for (const auto& [name, address] : image->symbols) symbols.push_back(name);
  return fmt::format("\"{}\" is neither a symbol of the program nor a 32-bit address (300000h, 0x300000 or decimal){}",
                     text, io::suggestion(io::nearest(text, symbols, io::most_wrong(text))));
}

void require_c40(const Image& image, std::string_view name) {
  if (image.cpu == isa::Cpu::c40) return;
  throw WrongProcessor(fmt::format(
      "{}: a program of the TMS320{}; only programs for the TMS320C40 run here (asm, link and disasm accept the {}'s)",
      name, isa::title(image.cpu), isa::title(image.cpu)));
}

std::string listing(const Image& image) {
  std::string out;
  if (image.cpu != isa::Cpu::c40) out += fmt::format("cpu {}\n", isa::name(image.cpu));
  for (const std::string& dialect : image.dialects) out += fmt::format("dialect {}\n", dialect);
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
  for (const auto& [name, value] : image.names()) out += fmt::format("{:08x} {}\n", value, name);
  return io::printable(out);  // a listing is shown in a terminal
}

}  // namespace toolchain
