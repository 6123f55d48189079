#include "toolchain/linker/linker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "isa/types.hpp"
#include "toolchain/linker/initial_values.hpp"
#include "toolchain/linker/link_map.hpp"
#include "toolchain/linker/placement.hpp"
#include "toolchain/linker/program_objects.hpp"
#include "toolchain/objects/archive.hpp"
#include "toolchain/objects/coff.hpp"
#include "toolchain/objects/section_places.hpp"

namespace toolchain {
namespace {

std::string join(const std::vector<std::string>& messages) { return fmt::format("{}", fmt::join(messages, "\n")); }

/// A global symbol's definition.
struct Definition {
  Word value = 0;
  const Object* object = nullptr;  ///< Null if the memory map or the linker itself defines the symbol.
  bool is_address = false;
  bool is_loaded = false;  ///< An address in a section that an object loads.
};

class Linker {
 public:
  Linker(std::vector<Object> objects, isa::Cpu cpu, const MemoryMap& map)
      : objects_(std::move(objects)), cpu_(cpu), map_(map) {}

  Linked link() {
    collect_sections();
    if (std::ranges::all_of(placement_.sections(), [](const OutputSection& section) { return section.size == 0; }))
      throw LinkError(
          {fmt::format("{}: no section contains a word; a program has at least one", objects_.front().name)});
    placement_.place(map_, cpu_, errors_);
    check_small_model();
    define_symbols();
    check_undefined();
    if (!errors_.empty()) throw LinkError(std::move(errors_));
    Linked out;
    out.image.cpu = cpu_;
    build(out.image);
    export_symbols(out.image);
    out.image.entry = entry();
    if (!errors_.empty()) throw LinkError(std::move(errors_));
    out.image.warnings = std::move(warnings_);
    out.map = link_map(out.image, map_, placement_, objects_);
    return out;
  }

 private:
  void complain(std::string message) {
    if (errors_.size() < most_errors) errors_.push_back(std::move(message));
  }
  template <class Act>
  void or_complain(const Act& act) {
    try {
      act();
    } catch (const CoffError& error) {
      complain(error.what());
    }
  }

  void collect_sections() {
    for (std::size_t i = 0; i < objects_.size(); ++i)
      for (std::size_t k = 0; k < objects_[i].sections.size(); ++k) placement_.add(objects_[i].sections[k], {i, k});
    for (const char* name : {".text", ".data", ".bss"}) placement_.need(name);  // their ends are symbols
    placement_.find(".bss")->rather_in_one_page = map_.is_c;                    // the small model keeps one page in DP
    // .cinit ends with a count of 0 (c40-hardware.md 10.2).
    OutputSection* const table = placement_.find(initial_values);
    if (table == nullptr || table->size == 0) return;
    ++table->size;
    table->for_loader = map_.loader_sets_values;
  }

  void check_small_model() {
    const OutputSection& bss = *placement_.find(".bss");
    const std::uint64_t in = pages(bss.address, bss.size);
    if (!bss.rather_in_one_page || in <= 1) return;
    warnings_.push_back(fmt::format(
        "{}: warning: .bss ({} words at {:08X}h) lies in {} pages of 64 K words; a program of the small model reaches "
        "only the first{}",
        linked_program, bss.size, bss.address, in == 2 ? "two" : std::to_string(in),
        is_split(bss.address, bss.size) ? ". The memory map may give another place" : ", one of the big model all"));
  }

  /// How far an object's section was moved.
  Word move_of(std::size_t object, std::size_t section) const {
    return placement_.address_of({object, section}) - objects_[object].sections[section].address;
  }

  Word final_value(std::size_t object, const ObjectSymbol& symbol) const {
    if (symbol.section == ObjectSymbol::absolute) return symbol.value;
    return symbol.value + move_of(object, static_cast<std::size_t>(symbol.section));
  }

  void define_symbols() {
    for (const auto& [name, value] : map_.symbols) globals_[name] = {.value = value};
    for (std::size_t i = 0; i < objects_.size(); ++i)
      for (const ObjectSymbol& symbol : objects_[i].symbols) {
        if (!symbol.defines()) continue;
        const Definition definition{final_value(i, symbol), &objects_[i], symbol.section >= 0,
                                    is_loaded(objects_[i], symbol)};
        const auto [at, fresh] = globals_.insert({symbol.name, definition});
        if (!fresh)
          complain(fmt::format("{}: '{}' is defined already in {}", objects_[i].name, symbol.name,
                               at->second.object != nullptr ? at->second.object->name : "the memory map"));
      }
    constexpr Word no_table = 0xFFFFFFFF;  // The value that TI's linker uses (c40-hardware.md 10.2).
    const OutputSection* const table = map_.loader_sets_values ? nullptr : placement_.find(initial_values);
    define_own("cinit", table != nullptr && table->size != 0 ? table->address : no_table);
    define_size("__STACK_SIZE", ".stack");
    define_size("__SYSMEM_SIZE", ".sysmem");
    const auto end_of = [&](std::string_view name) {
      const OutputSection* const section = placement_.find(name);
      return section->address + section->size;
    };
    define_own("etext", end_of(".text"));
    define_own("edata", end_of(".data"));
    define_own("end", end_of(".bss"));
    for (const OutputSection& section : placement_.sections()) define_own(section.name, section.address);
  }

  /// The symbols that TI's linker defines itself, unless the objects do: the start or end of a section.
  void define_own(const std::string& name, Word value) {
    globals_.insert({name, {.value = value, .is_address = true}});
    globals_.insert({"_" + name, {.value = value, .is_address = true}});
    own_.insert({name, "_" + name});
  }

  /// The final number of words of the section, which its own source cannot know.
  void define_size(const std::string& name, std::string_view of) {
    const OutputSection* section = placement_.find(of);
    globals_.insert({name, {.value = section != nullptr ? section->size : 0}});
    own_.insert(name);
  }

  void check_undefined() {
    std::map<std::string, std::string> missing;  // With the place of its first reference.
    for (const Object& object : objects_)
      for (const ObjectSymbol& symbol : object.symbols)
        if (symbol.section == ObjectSymbol::undefined && !globals_.contains(symbol.name))
          missing.emplace(symbol.name, first_reference(object, symbol));
    for (const auto& [name, where] : missing) complain(fmt::format("{}: undefined symbol '{}'", where, name));
    if (!map_.entry.empty() && !globals_.contains(map_.entry) && !find_local(map_.entry, false))
      complain(fmt::format("the entry symbol '{}' is not defined", map_.entry));
  }

  static std::string first_reference(const Object& object, const ObjectSymbol& symbol) {
    const auto index = static_cast<int>(&symbol - object.symbols.data());
    for (const ObjectSection& section : object.sections)
      for (const Relocation& relocation : section.relocations)
        if (relocation.symbol == index)
          return fmt::format("{}: {}+{:X}h", object.name, section.name, relocation.offset);
    return object.name;
  }

  void build(Image& image) {
    for (const OutputSection& section : placement_.sections()) {
      if (section.size == 0) continue;
      Image::Section out{section.name, section.address, section.size, {}, section.loaded};
      if (section.loaded) {
        out.words.resize(section.size);
        for (const OutputSection::Part& part : section.parts) {
          copy(part, out);
          add_lines(part, section.address + part.offset, image);
        }
      }
      if (section.name == initial_values)
        for (std::string& doubt : doubts_about_initial_values(section, out.words, objects_, linked_program))
          warnings_.push_back(std::move(doubt));
      if (section.for_loader)
        or_complain([&] { set_initial_values(std::move(out), image, linked_program); });
      else
        image.sections.push_back(std::move(out));
    }
    if (map_.loader_sets_values)  // Initial values may be for any address.
      or_complain([&] { check_overlaps(image, linked_program); });
  }

  /// For the next section.
  static std::uint32_t file_number(Image& image, const std::string& name) {
    const auto found = std::ranges::find(image.files, name);
    if (found == image.files.end()) image.files.push_back(name);
    return static_cast<std::uint32_t>(std::ranges::find(image.files, name) - image.files.begin());
  }
  void add_lines(const OutputSection::Part& part, Address address, Image& image) const {
    const Object& object = objects_[part.source.object];
    for (const ObjectLine& line : object.sections[part.source.section].lines)
      image.lines.push_back({address + line.offset,
                             file_number(image, object.files[line.file]),
                             line.line,
                             {},
                             static_cast<std::uint32_t>(image.sections.size()),
                             {}});
  }

  void copy(const OutputSection::Part& part, Image::Section& out) {
    const Object& object = objects_[part.source.object];
    const ObjectSection& section = object.sections[part.source.section];
    std::copy(section.words.begin(), section.words.end(), out.words.begin() + part.offset);
    for (const Relocation& relocation : section.relocations) {
      Word& word = out.words[part.offset + relocation.offset];
      word = relocated(part, section, relocation, word);
    }
  }

  Word relocated(const OutputSection::Part& part, const ObjectSection& section, const Relocation& relocation,
                 Word word) {
    const Object& object = objects_[part.source.object];
    const Word place_then = section.address + relocation.offset;
    const Word place_now = place_then + move_of(part.source.object, part.source.section);
    const bool own = relocation.symbol == Relocation::own_section;
    const ObjectSymbol* symbol = own ? nullptr : &object.symbols[static_cast<std::size_t>(relocation.symbol)];
    Word then = section.address, now = section.address + move_of(part.source.object, part.source.section);
    bool is_address = own || symbol->section >= 0;
    if (symbol != nullptr && symbol->section == ObjectSymbol::undefined) {
      const Definition& definition = globals_.find(symbol->name)->second;
      then = 0;
      now = definition.value;
      is_address = definition.is_address;
    } else if (symbol != nullptr) {
      then = symbol->value;
      now = final_value(part.source.object, *symbol);
    }
    const bool is_section = own || symbol->stands_for_section;
    const Relocated out = relocate(word, relocation, then, now, place_then, place_now, is_section, is_address);
    const std::string name = own ? section.name : symbol->name;
    if (!out.fits)
      complain(fmt::format("{}: {}+{:X}h: {} is out of reach: {} {} does not fit in the {} bits of {}", object.name,
                           section.name, relocation.offset, name,
                           is_relative(relocation.type) ? "a distance of" : "the value", out.value,
                           width(relocation.type), toolchain::name(relocation.type)));
    if (relocation.type == RelocationType::partms16 && relocation.low == 0 && is_section && symbol != nullptr &&
        symbol->section >= 0)
      check_page(object, *symbol, section, relocation, now);
    return out.word;
  }

  /// A high half that refers to a whole section does not say which place in the section. If the section lies in two
  /// pages, the page may be wrong.
  void check_page(const Object& object, const ObjectSymbol& symbol, const ObjectSection& section,
                  const Relocation& relocation, Word now) {
    const Address size = object.sections[static_cast<std::size_t>(symbol.section)].size;
    if (size == 0 || now >> 16 == (now + size - 1) >> 16) return;
    if (!warned_.insert(&symbol).second) return;
    warnings_.push_back(fmt::format(
        "{}: {}+{:X}h: warning: the object gives the page of {} but not the place in it, and {} lies in two pages "
        "({:08X}h, {} words); put it on a multiple of 10000h",
        object.name, section.name, relocation.offset, symbol.name, symbol.name, now, size));
  }

  static bool is_loaded(const Object& object, const ObjectSymbol& symbol) {
    return symbol.section >= 0 && object.sections[static_cast<std::size_t>(symbol.section)].loaded;
  }

  /// The value of the first local symbol with this name.
  std::optional<Word> find_local(std::string_view name, bool in_loaded_section) const {
    for (std::size_t i = 0; i < objects_.size(); ++i)
      for (const ObjectSymbol& symbol : objects_[i].symbols)
        if (!symbol.global && symbol.name == name && names_a_value(objects_[i], symbol) &&
            (!in_loaded_section || is_loaded(objects_[i], symbol)))
          return final_value(i, symbol);
    return std::nullopt;
  }

  /// Global symbols, then local ones.
  void export_symbols(Image& image) const {
    std::set<std::string, std::less<>> referred;
    for (const Object& object : objects_)
      for (const ObjectSymbol& symbol : object.symbols)
        if (symbol.section == ObjectSymbol::undefined) referred.insert(symbol.name);
    for (const auto& [name, definition] : globals_)
      if (definition.object != nullptr || !own_.contains(name) || referred.contains(name))
        image.symbols[name] = definition.value;
    for (std::size_t i = 0; i < objects_.size(); ++i)
      for (const ObjectSymbol& symbol : objects_[i].symbols)
        if (!symbol.global && names_a_value(objects_[i], symbol)) image.add_symbol(symbol.name, final_value(i, symbol));
  }

  /// A global symbol comes before a local one of the same name.
  Address entry() const {
    if (!map_.entry.empty()) {
      const auto found = globals_.find(map_.entry);
      return found != globals_.end() ? found->second.value : *find_local(map_.entry, false);
    }
    for (const std::string_view name : usual_entries) {
      const auto found = globals_.find(name);
      if (found != globals_.end() && found->second.is_loaded) return found->second.value;
      if (const auto local = find_local(name, true)) return *local;
    }
    const OutputSection* text = placement_.find(".text");
    if (text->size != 0) return text->address;
    return std::ranges::find_if(placement_.sections(),
                                [](const auto& section) { return section.size != 0 && !section.for_loader; })
        ->address;
  }

  static constexpr std::size_t most_errors = 1000;
  static constexpr const char* linked_program = "the linked program";

  std::vector<Object> objects_;
  isa::Cpu cpu_;
  const MemoryMap& map_;
  Placement placement_;
  std::map<std::string, Definition, std::less<>> globals_;
  std::set<std::string, std::less<>> own_;  ///< Names that the linker itself would define.
  std::set<const ObjectSymbol*> warned_;
  std::vector<std::string> errors_, warnings_;
};

}  // namespace

LinkError::LinkError(std::vector<std::string> messages)
    : std::runtime_error(join(messages)), messages_(std::move(messages)) {}

Linked link(std::vector<Object> objects, const std::vector<Object>& library, const MemoryMap& map) {
  if (objects.empty()) throw LinkError({"nothing to link"});
  const isa::Cpu cpu = complete(objects, library, map);
  return Linker(std::move(objects), cpu, map).link();
}

Linked link_files(const std::vector<std::filesystem::path>& files, const MemoryMap& map) {
  std::vector<Object> objects, library;
  const auto add = [](std::vector<Object>& to, Object object) {
    if (object.executable)
      throw LinkError({fmt::format(
          "{}: is already linked; a relocatable object is expected, as of `emulator asm --object`", object.name)});
    to.push_back(std::move(object));
  };
  for (const auto& path : files) {
    const auto bytes = read_bytes(path);
    if (!is_archive(bytes)) {
      add(objects, read_object(bytes, path.string()));
      continue;
    }
    for (const ArchiveMember& member : archive_members(bytes, path.string()))
      add(library, read_object(member.bytes, fmt::format("{}({})", path.string(), member.name)));
  }
  return link(std::move(objects), library, map);
}

}  // namespace toolchain
