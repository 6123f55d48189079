#include "toolchain/disassembler/disassembly.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "isa/ascii.hpp"
#include "isa/disassemble.hpp"
#include "toolchain/encoder/encoder.hpp"
#include "toolchain/syntax/parser.hpp"

namespace toolchain {
namespace {

using Labels = std::map<Address, std::string>;

/// Whether the section is a .cinit that the loader reads: it lies in no memory, and its records follow it.
bool is_table_for_loader(const Image& image, const Image::Section& section) {
  const std::size_t next = static_cast<std::size_t>(&section - image.sections.data()) + 1;
  return !section.initial_values && next < image.sections.size() && image.sections[next].initial_values;
}

/// Names of addresses within the sections, and so many words behind them; if an address has several, the first in the
/// alphabet.
template <class Names>
Labels labels_of(const Image& image, const Names& names, Address behind) {
  Labels out;
  for (const auto& [name, value] : names)
    for (const auto& section : image.sections)
      if (section.size != 0 && value - section.address < section.size + behind && !name.starts_with('.') &&
          !is_table_for_loader(image, section))
        out.emplace(value, name);
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

/// The label behind the last word of a section with contents; empty: there is none.
template <class Section>
std::string label_at_end(const Section& section, const isa::SymbolLookup& lookup) {
  if (section.words.empty()) return {};
  const std::string label = lookup(section.address + static_cast<Address>(section.words.size()));
  return label.empty() ? label : label + ":\n";
}

/// The name of the address; a new one if it has none.
const std::string& named(Address address, const Image& image, Labels& labels) {
  std::string name = fmt::format("L{:X}", address);
  while (!labels.contains(address) && image.symbols.contains(name)) name += '_';
  return labels.emplace(address, std::move(name)).first->second;
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
        if (target - other.address < other.words.size()) named(target, image, labels);
    }
  }
}

std::string head(isa::Cpu cpu) {
  return cpu == isa::Cpu::c40 ? std::string() : fmt::format("; cpu {}\n", isa::name(cpu));
}

std::string_view purpose(const Image& image, const Image::Section& section) {
  if (is_table_for_loader(image, section)) return ", for the loader, which sets the initial values:";
  return section.loaded ? "" : ", reserved";
}

/// The parts of the sections as a source has them: no two share a word. What the loader sets, or another section
/// holds, is cut out of reserved memory; the further pieces get names of their own.
class SourceParts {
 public:
  explicit SourceParts(const Image& image) {
    for (const auto& section : image.sections) names_.insert(section.name);
    for (const auto& section : image.sections)
      if (section.loaded) taken_.emplace(section.address, std::uint64_t{section.address} + section.size);
    for (const auto& section : image.sections)
      if (section.loaded)
        parts_.push_back({section.name, section.address, section.size, section.words, true, false});
      else if (!is_table_for_loader(image, section))
        add_reserved(section);
  }

  const std::vector<Image::Section>& parts() const { return parts_; }

 private:
  void add_reserved(const Image::Section& section) {
    std::uint64_t at = section.address;
    const std::uint64_t end = at + section.size;
    int number = 0;
    const auto add_up_to = [&](std::uint64_t stop) {
      if (stop <= at) return;
      const auto from = static_cast<Address>(at);
      std::string name = section.name;
      while (number > 0 && !names_.insert(name = fmt::format("{}.{}", section.name, number)).second) ++number;
      ++number;
      parts_.push_back({std::move(name), from, static_cast<Address>(stop - at), {}, false, false});
    };
    for (const auto& [begin, stop] : taken_) {
      if (stop <= at || begin >= end) continue;
      add_up_to(begin);
      at = std::max<std::uint64_t>(at, stop);
    }
    add_up_to(end);
    taken_.emplace(section.address, end);
  }

  std::vector<Image::Section> parts_;
  std::set<std::string, std::less<>> names_;
  std::multimap<std::uint64_t, std::uint64_t> taken_;  ///< Begin and end of what the source already has.
};

/// Reserved words, from one label to the next; there is one at the beginning.
std::string reserved_source(const Image::Section& part, const Labels& labels) {
  std::string out;
  const std::uint64_t end = std::uint64_t{part.address} + part.size;
  for (auto label = labels.find(part.address); label != labels.end() && label->first < end;) {
    const auto& [at, name] = *label++;
    const std::uint64_t stop = label == labels.end() ? end : std::min<std::uint64_t>(end, label->first);
    fmt::format_to(std::back_inserter(out), "{}\t.usect\t\"{}\",{}\n", name, part.name, stop - at);
  }
  return out;
}

/// As an argument of a shell's command.
std::string argument(const std::string& text) {
  if (std::ranges::all_of(text, [](char c) {
        return ascii::is_letter_or_digit(c) || std::string_view("_.=:").find(c) != std::string_view::npos;
      }))
    return text;
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace

std::string disassembly(const Image& image) {
  const Labels labels = labels_of(image, image.names(), 1);
  const auto lookup = lookup_in(labels);
  std::string out = head(image.cpu);
  for (const auto& section : image.sections) {
    fmt::format_to(std::back_inserter(out), "; section {}, {} words at {:08X}h{}\n", section.name, section.size,
                   section.address, purpose(image, section));
    // A label at the beginning of reserved words may be one behind the section before.
    if (section.words.empty())
      if (const std::string label = lookup(section.address); !label.empty()) out += label + ":\n";
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
    const auto is_at_end = [end = section.address + section.size](const auto& other) {
      return end - other.address < other.size;
    };
    if (std::ranges::none_of(image.sections, is_at_end)) out += label_at_end(section, lookup);
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
    out += label_at_end(section, lookup);
  }
  return out;
}

std::string source_of(const Image& image) {
  Labels labels;
  for (const auto& [address, name] : labels_of(image, image.symbols, 0))
    if (can_be_written(name)) labels.emplace(address, name);
  add_targets(image, labels);
  const std::string entry = named(image.entry, image, labels);
  const SourceParts source(image);
  for (const auto& part : source.parts())
    if (!part.loaded) named(part.address, image, labels);
  const auto lookup = lookup_in(labels);
  std::string out = "; emulator asm FILE -o OUT";
  if (image.cpu != isa::Cpu::c40) out += fmt::format(" --cpu {}", isa::name(image.cpu));
  for (const auto& part : source.parts())
    out += " --section " + argument(fmt::format("{}={:#x}", part.name, part.address));
  out += fmt::format(" --entry {}\n", entry);
  for (const auto& part : source.parts()) {
    if (!part.loaded) {
      out += reserved_source(part, labels);
      continue;
    }
    out += fmt::format("\t.sect\t\"{}\"\n", part.name);
    const bool data = is_data(part);
    Address address = part.address;
    for (const Word word : part.words) {
      if (const std::string label = lookup(address); !label.empty()) out += label + ":\n";
      if (data)
        fmt::format_to(std::back_inserter(out), "\t.word\t{:#010x}\n", word);
      else
        fmt::format_to(std::back_inserter(out), "\t{}\n", isa::disassemble(word, address, lookup, image.cpu));
      ++address;
    }
  }
  const bool entry_is_in_a_part =
      std::ranges::any_of(source.parts(), [&](const auto& part) { return image.entry - part.address < part.size; });
  if (!entry_is_in_a_part) out += fmt::format("{}\t.set\t{:#x}\n", entry, image.entry);
  return out;
}

}  // namespace toolchain
