#include "toolchain/linker/linker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "io/print.hpp"
#include "isa/types.hpp"
#include "toolchain/linker/placement.hpp"
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
  Linker(std::vector<Object> objects, std::vector<Object> library, const MemoryMap& map)
      : objects_(std::move(objects)), library_(std::move(library)), map_(map) {}

  Linked link() {
    if (objects_.empty()) throw LinkError({"nothing to link"});
    pull_from_library();
    check_processors();
    add_common();
    collect_sections();
    if (std::ranges::all_of(placement_.sections(), [](const OutputSection& section) { return section.size == 0; }))
      throw LinkError(
          {fmt::format("{}: no section contains a word; a program has at least one", objects_.front().name)});
    placement_.place(map_, cpu(), errors_);
    check_small_model();
    define_symbols();
    check_undefined();
    if (!errors_.empty()) throw LinkError(std::move(errors_));
    Linked out;
    out.image.cpu = cpu();
    build(out.image);
    export_symbols(out.image);
    out.image.entry = entry();
    if (!errors_.empty()) throw LinkError(std::move(errors_));
    out.image.warnings = std::move(warnings_);
    out.map = map_text(out.image);
    return out;
  }

 private:
  void complain(std::string message) {
    if (errors_.size() < most_errors) errors_.push_back(std::move(message));
  }

  static bool defines(const ObjectSymbol& symbol) { return symbol.global && symbol.section != ObjectSymbol::undefined; }

  void pull_from_library() {
    std::map<std::string, std::size_t, std::less<>> offers;
    for (std::size_t i = 0; i < library_.size(); ++i)
      for (const ObjectSymbol& symbol : library_[i].symbols)
        if (defines(symbol)) offers.emplace(symbol.name, i);
    std::set<std::string, std::less<>> defined;
    std::set<std::size_t> taken;
    for (const auto& [name, value] : map_.symbols) defined.insert(name);
    for (const Object& object : objects_)
      for (const ObjectSymbol& symbol : object.symbols)
        if (defines(symbol)) defined.insert(symbol.name);
    const auto want = [&](const std::string& name) {
      const auto offer = offers.find(name);
      if (defined.contains(name) || offer == offers.end() || !taken.insert(offer->second).second) return;
      objects_.push_back(library_[offer->second]);
      for (const ObjectSymbol& symbol : objects_.back().symbols)
        if (defines(symbol)) defined.insert(symbol.name);
    };
    if (!map_.entry.empty()) want(map_.entry);
    if (map_.entry.empty() && map_.is_c) want("_c_int00");
    for (std::size_t i = 0; i < objects_.size(); ++i) {  // Grows while it is walked.
      const auto symbols = objects_[i].symbols;
      for (const ObjectSymbol& symbol : symbols)
        if (symbol.section == ObjectSymbol::undefined) want(symbol.name);
    }
  }

  /// The first object with a word decides the program's processor; an object without words does not.
  const Object& leader() const {
    const auto found = std::ranges::find_if(objects_, holds_words);
    return found == objects_.end() ? objects_.front() : *found;
  }
  static bool holds_words(const Object& object) {
    return std::ranges::any_of(object.sections, [](const ObjectSection& section) { return section.size != 0; });
  }
  isa::Cpu cpu() const { return leader().cpu; }

  void check_processors() const {
    std::vector<std::string> errors;
    for (const Object& object : objects_)
      if (object.cpu != cpu() && holds_words(object))
        errors.push_back(
            fmt::format("{}: is for the {}, and {} for the {}; all objects of a program must be for one processor",
                        object.name, isa::title(object.cpu), leader().name, isa::title(cpu())));
    if (!errors.empty()) throw LinkError(std::move(errors));
  }

  /// Undefined symbols that have a size, and that no object defines, get this number of words of .bss.
  void add_common() {
    std::map<std::string, Word> wanted;
    std::set<std::string> defined;
    for (const Object& object : objects_)
      for (const ObjectSymbol& symbol : object.symbols) {
        if (defines(symbol)) defined.insert(symbol.name);
        if (symbol.section == ObjectSymbol::undefined && symbol.value != 0)
          wanted[symbol.name] = std::max(wanted[symbol.name], symbol.value);
      }
    Object common;
    common.name = "common storage";
    common.cpu = cpu();
    ObjectSection bss;
    bss.name = ".bss";
    bss.loaded = false;
    for (const auto& [name, size] : wanted) {
      if (defined.contains(name)) continue;
      common.symbols.push_back(
          {.name = name, .value = bss.size, .section = 0, .global = true, .stands_for_section = false});
      bss.size += size;
    }
    if (common.symbols.empty()) return;
    common.sections.push_back(std::move(bss));
    objects_.push_back(std::move(common));
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
        if (!defines(symbol)) continue;
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
      if (section.name == initial_values) check_initial_values(section, out.words);
      if (section.for_loader)
        return_to_loader(out, image);
      else
        image.sections.push_back(std::move(out));
    }
    if (!map_.loader_sets_values) return;
    try {
      check_overlaps(image, linked_program);  // Initial values may be for any address.
    } catch (const CoffError& error) {
      complain(error.what());
    }
  }

  /// What would be lost in silence: the program, and the loader, read the table up to the first count of 0.
  void check_initial_values(const OutputSection& table, const std::vector<Word>& records) {
    if (records.empty()) return;
    std::size_t end = 0;
    try {
      Image unused;
      end = add_initial_values(unused, table.name, records, fmt::format("{}: warning", linked_program));
    } catch (const CoffError& error) {
      if (!table.for_loader) warnings_.emplace_back(error.what());  // else it is an error (return_to_loader)
      return;
    }
    if (end >= records.size())
      warnings_.push_back(fmt::format("{}: warning: the last record of {} asks for one word more than it has",
                                      linked_program, table.name));
    const auto lost = std::find_if(records.begin() + static_cast<std::ptrdiff_t>(std::min(end, records.size())),
                                   records.end(), [](Word word) { return word != 0; });
    if (lost == records.end()) return;
    const auto place = static_cast<Address>(lost - records.begin());
    const auto next = std::ranges::find_if(table.parts, [&](const auto& part) { return part.offset > place; });
    const OutputSection::Part& part = *std::prev(next);
    warnings_.push_back(
        fmt::format("{}: {}+{:X}h: warning: the initial values from here on are not set; a 0 before them, in word {} "
                    "of {}, closes the table",
                    objects_[part.source.object].name, table.name, place - part.offset, end, table.name));
  }

  /// The table itself stays as a section that reserves nothing: only its name and size.
  void return_to_loader(Image::Section& table, Image& image) {
    const std::vector<Word> records = std::move(table.words);
    table.words.clear();
    table.loaded = false;
    const std::string name = table.name;
    image.sections.push_back(std::move(table));
    try {
      add_initial_values(image, name, records, linked_program);
    } catch (const CoffError& error) {
      complain(error.what());
    }
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

  std::string map_text(const Image& image) const {
    std::string out = fmt::format("entry {:08X}h\n\nmemory            origin     length       used\n", image.entry);
    for (const auto& memory : map_.memories) {
      std::uint64_t used = 0;
      for (const OutputSection& section : placement_.sections())
        if (!section.for_loader && section.address >= memory.origin && section.address - memory.origin < memory.length)
          used += section.size;
      out += fmt::format("{:<16} {:08X}h {:>9X}h {:>9X}h\n", memory.name, memory.origin, memory.length, used);
    }
    out += "\nsection          address         size  from\n";
    for (const OutputSection& section : placement_.sections()) {
      if (section.size == 0 && section.parts.empty()) continue;
      out += fmt::format("{:<16} {:08X}h {:>9X}h{}\n", section.name, section.address, section.size,
                         section.for_loader ? "  for the loader"
                         : section.loaded   ? ""
                                            : "  reserved");
      for (const auto& part : section.parts) {
        const Object& object = objects_[part.source.object];
        const Address size = object.sections[part.source.section].size;
        if (size != 0)
          out += fmt::format("{:<16} {:08X}h {:>9X}h  {}\n", "", section.address + part.offset, size, object.name);
      }
    }
    out += "\naddress    symbol\n";
    std::vector<std::pair<Word, std::string_view>> by_address;
    for (const auto& [name, value] : image.names()) by_address.emplace_back(value, name);
    std::sort(by_address.begin(), by_address.end());
    for (const auto& [value, name] : by_address) out += fmt::format("{:08X}h  {}\n", value, name);
    return io::printable(out);
  }

  static constexpr std::size_t most_errors = 1000;
  static constexpr const char* linked_program = "the linked program";
  static constexpr const char* initial_values = ".cinit";

  std::vector<Object> objects_;
  std::vector<Object> library_;
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

Linked link(std::vector<Object> objects, std::vector<Object> library, const MemoryMap& map) {
  return Linker(std::move(objects), std::move(library), map).link();
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
  return link(std::move(objects), std::move(library), map);
}

}  // namespace toolchain
