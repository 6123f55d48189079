#include "toolchain/disassembler/disassembly.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "isa/disassemble.hpp"
#include "toolchain/encoder/encoder.hpp"
#include "toolchain/syntax/parser.hpp"

namespace toolchain {
namespace {

using Labels = std::map<Address, std::string>;

/// Names of addresses within the sections; if an address has several, the first in the alphabet.
Labels labels_of(const Image& image) {
  Labels out;
  for (const auto& [name, value] : image.symbols)
    for (const auto& section : image.sections)
      if (value - section.address < section.size && !name.starts_with('.')) out.emplace(value, name);
  return out;
}

isa::SymbolLookup lookup_in(const Labels& labels) {
  return [&labels](Address address) {
    const auto found = labels.find(address);
    return found == labels.end() ? std::string() : found->second;
  };
}

bool can_be_written(std::string_view name) {
  return !name.empty() && is_identifier_start(name[0]) && name[0] != '.' &&
         std::all_of(name.begin(), name.end(), is_identifier) && !isa::register_named(name) &&
         !isa::register_named(name, isa::Cpu::c3x) && !isa::expansion_named(name) &&
         name.find_first_not_of('$') != std::string_view::npos && !(name.size() == 2 && name[0] == '$');
}

template <class Section>
bool is_data(const Section& section) {
  static const std::set<std::string_view> names{".data", ".const", ".cinit", ".rodata", ".sysmem"};
  return names.contains(section.name) || section.name.starts_with(".cinit.");
}

/// The instruction, or the word in a section of data.
template <class Section>
std::string meaning(const Section& section, Word word, Address address, const isa::SymbolLookup& lookup, isa::Cpu cpu) {
  return is_data(section) ? fmt::format(".word {:#010x}", word) : isa::disassemble(word, address, lookup, cpu);
}

/// The number of words from `first` on that equal the first one, where only the first has a label or a relocation.
/// Fewer than 8 do not count.
template <class Words, class Marked>
std::size_t equal_words(const Words& words, std::size_t first, const Marked& is_marked) {
  std::size_t end = first + 1;
  while (end < words.size() && words[end] == words[first] && !is_marked(end)) ++end;
  return end - first < 8 ? 1 : end - first;
}

/// The line in place of all but the first of such a run.
std::string folded(std::size_t run, Address first) {
  return run == 1 ? std::string()
                  : fmt::format("...       {} more of the same, to {:08X}h\n", run - 1, first + run - 1);
}

/// Adds a label at each branch target that has none, in loaded sections.
void add_targets(const Image& image, Labels& labels) {
  for (const auto& section : image.sections) {
    if (is_data(section)) continue;
    for (Address i = 0; i < section.words.size(); ++i) {
      const auto decoded = isa::decode(section.words[i], image.cpu);
      const auto* instruction = std::get_if<isa::Instruction>(&decoded);
      if (instruction == nullptr) continue;
      const bool relative = instruction->src1.is(isa::Operand::Kind::target);
      if (!relative && !instruction->src1.is(isa::Operand::Kind::address)) continue;
      const Address target = (relative ? section.address + i : 0) + static_cast<Word>(instruction->src1.value);
      for (const auto& other : image.sections)
        if (target - other.address < other.words.size()) labels.emplace(target, fmt::format("L{:X}", target));
    }
  }
}

std::string head(isa::Cpu cpu) {
  return cpu == isa::Cpu::c40 ? std::string() : fmt::format("; cpu {}\n", isa::name(cpu));
}

}  // namespace

std::string disassembly(const Image& image) {
  const Labels labels = labels_of(image);
  const auto lookup = lookup_in(labels);
  std::string out = head(image.cpu);
  for (const auto& section : image.sections) {
    fmt::format_to(std::back_inserter(out), "; section {}, {} words at {:08X}h{}\n", section.name, section.size,
                   section.address, section.loaded ? "" : ", reserved");
    const auto is_marked = [&](std::size_t i) { return labels.contains(section.address + static_cast<Address>(i)); };
    for (std::size_t i = 0, run = 0; i < section.words.size(); i += run) {
      const Address address = section.address + static_cast<Address>(i);
      const Word word = section.words[i];
      if (const std::string label = lookup(address); !label.empty()) out += label + ":\n";
      fmt::format_to(std::back_inserter(out), "{:08X}  {:08X}  {}\n", address, word,
                     meaning(section, word, address, lookup, image.cpu));
      run = equal_words(section.words, i, is_marked);
      out += folded(run, address);
    }
  }
  return out;
}

std::string disassembly(const Object& object) {
  std::string out = head(object.cpu);
  for (std::size_t i = 0; i < object.sections.size(); ++i) {
    const ObjectSection& section = object.sections[i];
    Labels labels;
    for (const ObjectSymbol& symbol : object.symbols)
      if (symbol.section == static_cast<int>(i) && !symbol.stands_for_section)
        labels.emplace(symbol.value, symbol.name);
    std::multimap<Address, const Relocation*> relocations;
    for (const Relocation& relocation : section.relocations) relocations.emplace(relocation.offset, &relocation);
    const auto lookup = lookup_in(labels);
    fmt::format_to(std::back_inserter(out), "; section {}, {} words{}\n", section.name, section.size,
                   section.words.empty() ? ", reserved" : "");
    const auto is_marked = [&](std::size_t word) {
      const auto offset = static_cast<Address>(word);
      return labels.contains(section.address + offset) || relocations.contains(offset);
    };
    std::size_t run = 0;
    for (Address at = 0; at < section.words.size(); at += static_cast<Address>(run)) {
      const Address address = section.address + at;
      if (const std::string label = lookup(address); !label.empty()) out += label + ":\n";
      const auto [first, last] = relocations.equal_range(at);
      // The target of a relocated branch does not follow from its word.
      const bool settled = std::none_of(first, last, [](const auto& r) {
        return is_relative(r.second->type) || r.second->type == RelocationType::rel24;
      });
      fmt::format_to(std::back_inserter(out), "{:08X}  {:08X}  {}", address, section.words[at],
                     meaning(section, section.words[at], address, settled ? lookup : isa::SymbolLookup(), object.cpu));
      for (auto r = first; r != last; ++r) {
        const int symbol = r->second->symbol;
        fmt::format_to(std::back_inserter(out), "  ; {} {}", name(r->second->type),
                       symbol < 0 ? section.name : object.symbols[static_cast<std::size_t>(symbol)].name);
      }
      out += '\n';
      run = first == last ? equal_words(section.words, at, is_marked) : 1;
      out += folded(run, address);
    }
  }
  return out;
}

std::string source_of(const Image& image) {
  Labels labels;
  for (const auto& [address, name] : labels_of(image))
    if (can_be_written(name)) labels.emplace(address, name);
  add_targets(image, labels);
  const auto lookup = lookup_in(labels);
  std::string out = "; emulator asm FILE -o OUT";
  if (image.cpu != isa::Cpu::c40) out += fmt::format(" --cpu {}", isa::name(image.cpu));
  for (const auto& section : image.sections) out += fmt::format(" --section {}={:#x}", section.name, section.address);
  out += '\n';
  for (const auto& section : image.sections) {
    if (!section.loaded) {
      const std::string label = lookup(section.address);
      out += fmt::format("{}\t.usect\t\"{}\",{}\n", label.empty() ? fmt::format("L{:X}", section.address) : label,
                         section.name, section.size);
      continue;
    }
    out += fmt::format("\t.sect\t\"{}\"\n", section.name);
    const bool data = is_data(section);
    Address address = section.address;
    for (const Word word : section.words) {
      if (const std::string label = lookup(address); !label.empty()) out += label + ":\n";
      if (data)
        fmt::format_to(std::back_inserter(out), "\t.word\t{:#010x}\n", word);
      else
        fmt::format_to(std::back_inserter(out), "\t{}\n", isa::disassemble(word, address, lookup, image.cpu));
      ++address;
    }
  }
  return out;
}

}  // namespace toolchain
