#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "io/input_file.hpp"
#include "io/print.hpp"
#include "isa/types.hpp"
#include "toolchain/objects/coff.hpp"
#include "toolchain/objects/coff_format.hpp"
#include "toolchain/objects/source_map.hpp"

namespace toolchain {
namespace {

using namespace coff;

class CoffReader {
 public:
  CoffReader(std::span<const std::byte> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  Object read() {
    object_.name = name_;
    read_file_header();
    if (optional_size_ >= optional_header) object_.entry = u32(header_size_ + 16, "the entry point");
    const std::size_t table = header_size_ + optional_size_;
    need(table, std::uint64_t{section_size_} * section_count_, "the section headers");
    for (std::size_t i = 0; i < section_count_; ++i) read_section(table + i * section_size_);
    read_symbols();
    for (std::size_t i = 0; i < section_count_; ++i) read_relocations(i, table + i * section_size_);
    for (std::size_t i = 0; i < section_count_; ++i) read_lines(object_.sections[i], table + i * section_size_);
    for (ObjectSection& section : object_.sections) section.name = shown(section.name);
    for (ObjectSymbol& symbol : object_.symbols) symbol.name = shown(symbol.name);
    for (std::string& file : object_.files) file = shown(file);
    return std::move(object_);
  }

 private:
  [[noreturn]] void fail(const std::string& why) const { throw CoffError(fmt::format("{}: {}", name_, shown(why))); }

  void need(std::uint64_t offset, std::uint64_t size, std::string_view what) const {
    if (offset > bytes_.size() || size > bytes_.size() - offset)
      fail(fmt::format("cut short: {} should be at bytes {} to {}, but the file has {}", what, offset, offset + size,
                       bytes_.size()));
  }

  std::uint32_t number(std::size_t offset, std::size_t size, bool big, std::string_view what) const {
    need(offset, size, what);
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i)
      value |= std::to_integer<std::uint32_t>(bytes_[offset + i]) << (8 * (big ? size - 1 - i : i));
    return value;
  }
  std::uint8_t u8(std::size_t offset, std::string_view what) const {
    return static_cast<std::uint8_t>(number(offset, 1, big_, what));
  }
  std::uint16_t u16(std::size_t offset, std::string_view what) const {
    return static_cast<std::uint16_t>(number(offset, 2, big_, what));
  }
  std::uint32_t u32(std::size_t offset, std::string_view what) const { return number(offset, 4, big_, what); }

  std::string text(std::size_t offset, std::size_t size, std::string_view what) const {
    need(offset, size, what);
    std::string out;
    for (std::size_t i = 0; i < size && bytes_[offset + i] != std::byte{0}; ++i)
      out += static_cast<char>(bytes_[offset + i]);
    return out;
  }

  /// For messages and Python strings: a damaged file may contain any bytes. The names change when all are read: the
  /// header's eight bytes of a longer name may end within a character.
  static std::string shown(const std::string& name) {
    std::string out;
    for (const char c : io::printable(name))
      out += c == '\n' || c == '\t' ? fmt::format("\\x{:02X}", c) : std::string(1, c);
    return out;
  }

  /// Tools on big-endian hosts wrote the headers in their byte order, but not the words.
  void read_magic() {
    for (const bool big : {false, true}) {
      big_ = big;
      const std::uint16_t magic = u16(0, "the magic number");
      object_.version = magic == target_id ? 0 : magic == magic_v1 ? 1 : magic == magic_v2 ? 2 : -1;
      if (object_.version >= 0) return;
    }
    big_ = false;
    fail(fmt::format("not a COFF file for the C3x/C4x: it starts with {:04X}h (known are 0093h, 00C1h, 00C2h)",
                     u16(0, "the magic number")));
  }

  void read_file_header() {
    if (bytes_.size() < file_header_v0) fail(fmt::format("not a COFF file: only {} bytes", bytes_.size()));
    read_magic();
    if (object_.version > 0) {
      const std::uint16_t target = u16(20, "the target");
      if (target != target_id)
        fail(fmt::format("is a COFF file for target {:04X}h, not for the C3x/C4x ({:04X}h)", target, target_id));
    }
    const std::uint16_t flags = u16(18, "the flags");
    object_.executable = (flags & executable) != 0;
    object_.cpu = (flags & c4x) != 0 ? isa::Cpu::c40 : isa::Cpu::c3x;
    section_count_ = u16(2, "the number of sections");
    symbols_at_ = u32(8, "the symbol table's place");
    symbol_count_ = u32(12, "the number of symbols");
    optional_size_ = u16(16, "the optional header's size");
    header_size_ = object_.version == 0 ? file_header_v0 : file_header_v12;
    section_size_ = object_.version == 2 ? section_header_v2 : section_header_v01;
    if (optional_size_ != 0) need(header_size_, optional_size_, "the optional header");
  }

  void read_section(std::size_t at) {
    ObjectSection section;
    section.name = section_name(at);
    section.address = u32(at + 8, "a section's address");
    section.size = u32(at + 16, "a section's size");
    const std::uint32_t where = u32(at + 20, "a section's place");
    const std::uint32_t flags =
        object_.version == 2 ? u32(at + 40, "a section's flags") : u16(at + 36, "a section's flags");
    // An empty section has no contents to point to: only its flags say what it is.
    section.loaded = (where != 0 || section.size == 0) && (flags & (dsect | noload | copy | bss)) == 0;
    section.table_of_copies = where != 0 && (flags & copy) != 0 && section.name == ".cinit";
    section.alignment = Address{1} << (flags >> alignment_shift & 15);
    section.blocked = (flags & block) != 0;
    if (std::uint64_t{section.address} + section.size > isa::address_space(object_.cpu))
      fail(fmt::format("section '{}' passes the end of the address space{}", section.name,
                       object_.cpu == isa::Cpu::c3x ? " of the C3x, 0FFFFFFh" : ""));
    if ((section.loaded || section.table_of_copies) && section.size != 0) read_words(section, where);
    object_.sections.push_back(std::move(section));
  }

  void read_words(ObjectSection& section, std::uint32_t where) {
    const std::uint64_t size = std::uint64_t{4} * section.size;
    need(where, size, fmt::format("the contents of section '{}'", section.name));
    contents_ += size;
    if (contents_ > bytes_.size()) fail("its sections claim more contents than the file has");
    section.words.reserve(section.size);
    for (std::size_t i = 0; i < section.size; ++i) section.words.push_back(number(where + 4 * i, 4, false, "a word"));
  }

  std::string section_name(std::size_t at) const {
    if (object_.version == 2 && u32(at, "a section's name") == 0 && u32(at + 4, "a section's name") != 0)
      return long_name(at);
    return text(at, 8, "a section's name");
  }

  void read_symbols() {
    if (symbol_count_ == 0) return;
    need(symbols_at_, std::uint64_t{symbol_entry} * symbol_count_, "the symbol table");
    for (std::uint32_t i = 0; i < symbol_count_; ++i) {
      const std::size_t at = symbols_at_ + symbol_entry * std::size_t{i};
      const auto section = static_cast<std::int16_t>(u16(at + 12, "a symbol's section"));
      const std::uint8_t storage = u8(at + 16, "a symbol's class");
      const std::uint8_t auxiliary = u8(at + 17, "a symbol's auxiliary count");
      if (auxiliary > symbol_count_ - 1 - i)
        fail(fmt::format("symbol {} claims more auxiliary entries than there are", i));
      if (section > static_cast<int>(object_.sections.size()))
        fail(fmt::format("a symbol lies in section {} of {}", section, object_.sections.size()));
      if (storage == class_file && auxiliary != 0) add_file(i, at + symbol_entry);
      if (storage == class_function && auxiliary != 0 && text(at, 8, "a symbol's name") == ".bf")
        function_lines_.emplace(i, u16(at + symbol_entry + 4, "a function's first line"));
      if (section >= absolute_section) add_symbol(i, at, section, storage, auxiliary);
      i += auxiliary;
    }
  }

  void add_file(std::uint32_t index, std::size_t at) {
    const bool is_long = u32(at, "a file's name") == 0 && u32(at + 4, "a file's name") != 0;
    files_.emplace(index, static_cast<std::uint32_t>(object_.files.size()));
    object_.files.push_back(is_long ? long_name(at) : text(at, file_name, "a file's name"));
  }

  /// Lines come after an entry that names a symbol. If it is a file, they are the file's own line numbers, as this
  /// assembler writes them. If it is a function, they count from the function's first line, as compilers do. Lines
  /// outside all sections are skipped: lines are not needed to run a program.
  void read_lines(ObjectSection& section, std::size_t header) {
    const std::uint32_t where = u32(header + 28, "a section's lines");
    const std::uint32_t count =
        object_.version == 2 ? u32(header + 36, "the number of lines") : u16(header + 34, "the number of lines");
    if (where > bytes_.size() || std::uint64_t{line_entry} * count > bytes_.size() - where) return;
    std::optional<std::uint32_t> file;
    int before = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::size_t at = where + line_entry * std::size_t{i};
      const std::uint32_t place = u32(at, "a line");
      const std::uint16_t line = u16(at + 4, "a line");
      if (line != 0) {
        if (file && place - section.address < section.size)
          section.lines.push_back({place - section.address, *file, before + line});
        continue;
      }
      const auto own = files_.upper_bound(place);
      file = own == files_.begin() ? std::nullopt : std::optional(std::prev(own)->second);
      const auto function = function_lines_.upper_bound(place);
      before = files_.contains(place) || function == function_lines_.end() ? 0 : function->second - 1;
    }
    std::ranges::stable_sort(section.lines, {}, &ObjectLine::offset);
  }

  void add_symbol(std::uint32_t index, std::size_t at, std::int16_t section, std::uint8_t storage,
                  std::uint8_t auxiliary) {
    ObjectSymbol symbol;
    const bool is_long =
        u32(at, "a symbol's name") == 0 && u32(at + 4, "a symbol's name") != 0;  // all zero is the empty name
    symbol.name = is_long ? long_name(at) : text(at, 8, "a symbol's name");
    symbol.value = u32(at + 8, "a symbol's value");
    symbol.section = section == undefined_section  ? ObjectSymbol::undefined
                     : section == absolute_section ? ObjectSymbol::absolute
                                                   : section - 1;
    symbol.global = storage == class_external;
    if (section > 0 && storage == class_static && auxiliary == 1) {
      ObjectSection& owner = object_.sections[static_cast<std::size_t>(section - 1)];
      symbol.stands_for_section = symbol.value == owner.address && symbol.name.starts_with(owner.name);
      if (symbol.stands_for_section && owner.name.size() == 8) owner.name = symbol.name;
    }
    symbol_indices_.emplace(index, static_cast<int>(object_.symbols.size()));
    object_.symbols.push_back(std::move(symbol));
  }

  /// Four zero bytes and an offset in the string table.
  std::string long_name(std::size_t at) const {
    const std::uint64_t strings = symbols_at_ + std::uint64_t{symbol_entry} * symbol_count_;
    const std::uint32_t offset = u32(at + 4, "a name");
    need(strings, 4, "the string table");
    const std::uint32_t size = u32(strings, "the string table");
    need(strings, size, "the string table");
    if (offset < 4 || offset >= size)
      fail(fmt::format("a name lies at {} in a string table of {} bytes", offset, size));
    return text(strings + offset, size - offset, "a name");
  }

  void read_relocations(std::size_t index, std::size_t header) {
    ObjectSection& section = object_.sections[index];
    const std::uint32_t where = u32(header + 24, "a section's relocations");
    const std::uint32_t count = object_.version == 2 ? u32(header + 32, "the number of relocations")
                                                     : u16(header + 32, "the number of relocations");
    if (count == 0) return;
    const std::size_t size = object_.version == 0 ? relocation_v0 : relocation_v12;
    need(where, std::uint64_t{size} * count, fmt::format("the relocations of section '{}'", section.name));
    if (object_.executable) return;  // A linked program does not need them.
    for (std::uint32_t i = 0; i < count; ++i)
      section.relocations.push_back(read_relocation(section, where + size * std::size_t{i}));
  }

  Relocation read_relocation(const ObjectSection& section, std::size_t at) const {
    Relocation out;
    const Address address = u32(at, "a relocation");
    out.offset = address - section.address;
    if (out.offset >= section.words.size())
      fail(fmt::format("a relocation at {:08X}h lies outside section '{}'", address, section.name));
    const std::int64_t index = object_.version == 0 ? static_cast<std::int16_t>(u16(at + 4, "a relocation"))
                                                    : static_cast<std::int32_t>(u32(at + 4, "a relocation"));
    const std::size_t tail = object_.version == 0 ? at + 6 : at + 8;
    const std::uint16_t kind = u16(tail + 2, "a relocation");
    const auto type = relocation_type(kind);
    if (!type)
      fail(fmt::format("the relocation at {:08X}h of section '{}' has the unknown type {:04X}h", address, section.name,
                       kind));
    out.type = *type;
    if (out.type == RelocationType::partms16) out.low = u16(tail, "a relocation");
    if (index == -1) return out;
    const auto symbol = symbol_indices_.find(static_cast<std::uint32_t>(index));
    if (index < 0 || symbol == symbol_indices_.end())
      fail(fmt::format("the relocation at {:08X}h of section '{}' names symbol {}, which does not exist", address,
                       section.name, index));
    out.symbol = symbol->second;
    return out;
  }

  std::span<const std::byte> bytes_;
  const std::string& name_;
  Object object_;
  bool big_ = false;
  std::size_t header_size_ = 0, section_size_ = 0, optional_size_ = 0;
  std::size_t section_count_ = 0, symbols_at_ = 0;
  std::uint32_t symbol_count_ = 0;
  std::uint64_t contents_ = 0;
  std::map<std::uint32_t, int> symbol_indices_;   ///< From the file's symbol numbers.
  std::map<std::uint32_t, std::uint32_t> files_;  ///< The source file of the symbols from a number on.
  std::map<std::uint32_t, int> function_lines_;   ///< By the number of the symbol at a function's begin.
};

Image linked(const Object& object) {
  if (!object.executable)
    throw CoffError(fmt::format(
        "{}: an object file that was not linked (emulator link FILE -o OUT); only executables can be loaded",
        object.name));
  return image_of(object);
}

}  // namespace

std::vector<std::byte> read_bytes(const std::filesystem::path& path) {
  const std::string bytes = io::read_file<CoffError>(path, "a COFF file");
  const auto view = std::as_bytes(std::span(bytes));
  return {view.begin(), view.end()};
}

Object read_object(std::span<const std::byte> bytes, const std::string& name) { return CoffReader(bytes, name).read(); }
Object read_object(const std::filesystem::path& path) { return read_object(read_bytes(path), path.string()); }

Image read_coff(std::span<const std::byte> bytes, const std::string& name) { return linked(read_object(bytes, name)); }
Image read_coff(const std::filesystem::path& path) {
  Image image = linked(read_object(path));
  add_source_text(image, path.parent_path());
  return image;
}

}  // namespace toolchain
