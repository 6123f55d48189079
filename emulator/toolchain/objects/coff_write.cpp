#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <ostream>

#include "io/output_file.hpp"
#include "toolchain/objects/coff.hpp"
#include "toolchain/objects/coff_format.hpp"

namespace toolchain {
namespace {

using namespace coff;

class FileBytes {
 public:
  void little(std::uint32_t value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) out_.push_back(static_cast<std::byte>(value >> (8 * i)));
  }
  void u8(std::uint32_t value) { little(value, 1); }
  void u16(std::uint32_t value) { little(value, 2); }
  void u32(std::uint32_t value) { little(value, 4); }
  /// Exactly `size` bytes, cut or padded with zeros.
  void text(std::string_view value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
      out_.push_back(i < value.size() ? static_cast<std::byte>(value[i]) : std::byte{0});
  }
  std::vector<std::byte> take() { return std::move(out_); }

 private:
  std::vector<std::byte> out_;
};

/// The kind of a section in the optional header.
std::uint32_t kind(const ObjectSection& section) {
  if (section.table_of_copies) return copy;
  if (!section.loaded) return bss;
  return section.name == ".text" ? text : data;
}

class CoffWriter {
 public:
  explicit CoffWriter(const Object& object) : object_(object), v2_(object.version == 2) {}

  std::vector<std::byte> write() {
    check();
    number_symbols();
    for (const auto& section : object_.sections) lines_.push_back(entries_of(section));
    write_file_header();
    write_section_headers();
    for (const auto& section : object_.sections)
      for (const Word word : section.words) out_.u32(word);
    for (const auto& section : object_.sections)
      for (const Relocation& relocation : section.relocations) write_relocation(section, relocation);
    for (const auto& lines : lines_)
      for (const LineEntry& line : lines) out_.u32(line.place), out_.u16(line.number);
    for (std::size_t file = 0; file < object_.files.size(); ++file) write_file(file);
    for (const ObjectSymbol& symbol : object_.symbols) write_symbol(symbol);
    out_.u32(static_cast<std::uint32_t>(4 + strings_.size()));
    out_.text(strings_, strings_.size());
    return out_.take();
  }

 private:
  void check() const {
    const auto refuse = [](std::size_t most, std::string_view what, std::size_t given) {
      if (given > most) throw std::runtime_error(fmt::format("a COFF file holds {} {}, not {}", most, what, given));
    };
    if (object_.executable &&
        std::ranges::all_of(object_.sections, [](const ObjectSection& section) { return section.size == 0; }))
      throw CoffError("the program contains no word; an executable has at least one");
    refuse(most_sections, "sections", object_.sections.size());
    for (const auto& section : object_.sections)
      if (!v2_) refuse(65535, "relocations of a section", section.relocations.size());
    if (object_.version == 0) refuse(32767, "symbols", object_.symbols.size());
  }

  std::size_t header_size() const { return object_.version == 0 ? file_header_v0 : file_header_v12; }
  std::size_t optional_size() const { return object_.executable ? optional_header : 0; }
  std::size_t section_size() const { return v2_ ? section_header_v2 : section_header_v01; }
  std::size_t relocation_size() const { return object_.version == 0 ? relocation_v0 : relocation_v12; }
  std::size_t contents_at() const { return header_size() + optional_size() + section_size() * object_.sections.size(); }
  std::size_t relocations_at() const {
    std::size_t words = 0;
    for (const auto& section : object_.sections) words += section.words.size();
    return contents_at() + 4 * words;
  }
  std::size_t lines_at() const {
    std::size_t count = 0;
    for (const auto& section : object_.sections) count += section.relocations.size();
    return relocations_at() + relocation_size() * count;
  }
  std::size_t symbols_at() const {
    std::size_t count = 0;
    for (const auto& lines : lines_) count += lines.size();
    return lines_at() + line_entry * count;
  }

  /// An entry without a line number names the file of the entries after it: its place is the number of the file's
  /// symbol.
  struct LineEntry {
    std::uint32_t place;
    std::uint16_t number;
  };
  std::vector<LineEntry> entries_of(const ObjectSection& section) const {
    constexpr int most_lines = 65535;  // Per file, and before version 2 per section.
    std::vector<LineEntry> entries;
    std::optional<std::uint32_t> file;
    for (const ObjectLine& line : section.lines) {
      if (line.line < 1 || line.line > most_lines) continue;
      if (!v2_ && entries.size() + 2 > most_lines) break;
      if (file != line.file) entries.push_back({2 * line.file, 0});
      file = line.file;
      entries.push_back({section.address + line.offset, static_cast<std::uint16_t>(line.line)});
    }
    return entries;
  }

  /// Files come first. They, and sections' symbols, have an auxiliary entry.
  void number_symbols() {
    auto next = static_cast<std::uint32_t>(2 * object_.files.size());
    for (const ObjectSymbol& symbol : object_.symbols) {
      symbol_numbers_.push_back(next);
      next += symbol.stands_for_section ? 2 : 1;
    }
    symbol_entries_ = next;
  }

  Address total(std::uint32_t wanted) const {
    Address words = 0;
    for (const auto& section : object_.sections)
      if (kind(section) == wanted) words += section.size;
    return words;
  }
  Address start(std::uint32_t wanted) const {
    for (const auto& section : object_.sections)
      if (kind(section) == wanted) return section.address;
    return 0;
  }

  void write_file_header() {
    bool relocations = false;
    for (const auto& section : object_.sections) relocations = relocations || !section.relocations.empty();
    constexpr std::array<std::uint16_t, 3> magic{target_id, magic_v1, magic_v2};
    out_.u16(magic[static_cast<std::size_t>(object_.version)]);
    out_.u16(static_cast<std::uint32_t>(object_.sections.size()));
    out_.u32(0);  // No time stamp: equal programs give equal files.
    out_.u32(static_cast<std::uint32_t>(symbols_at()));
    out_.u32(symbol_entries_);
    out_.u16(static_cast<std::uint32_t>(optional_size()));
    const bool lines = std::ranges::any_of(lines_, [](const auto& of) { return !of.empty(); });
    out_.u16((relocations ? 0U : no_relocations) | (object_.executable ? executable : 0U) |
             (lines ? 0U : no_line_numbers) | (object_.cpu == isa::Cpu::c40 ? c4x : 0U) | little_endian);
    if (object_.version > 0) out_.u16(target_id);
    if (!object_.executable) return;
    out_.u16(optional_magic);
    out_.u16(0);
    for (const std::uint32_t wanted : {text, data, bss}) out_.u32(total(wanted));
    out_.u32(object_.entry);
    for (const std::uint32_t wanted : {text, data}) out_.u32(start(wanted));
  }

  void write_section_headers() {
    std::size_t contents = contents_at(), relocations = relocations_at(), lines = lines_at();
    for (std::size_t i = 0; i < object_.sections.size(); ++i) {
      const ObjectSection& section = object_.sections[i];
      out_.text(section.name, 8);
      out_.u32(section.address);
      out_.u32(section.address);
      out_.u32(section.size);
      out_.u32(section.words.empty() ? 0 : static_cast<std::uint32_t>(contents));
      out_.u32(section.relocations.empty() ? 0 : static_cast<std::uint32_t>(relocations));
      out_.u32(lines_[i].empty() ? 0 : static_cast<std::uint32_t>(lines));
      const std::size_t count_size = v2_ ? 4 : 2;
      out_.little(static_cast<std::uint32_t>(section.relocations.size()), count_size);
      out_.little(static_cast<std::uint32_t>(lines_[i].size()), count_size);
      const auto alignment = static_cast<std::uint32_t>(std::bit_width(section.alignment) - 1);
      out_.little(kind(section) | alignment << alignment_shift | (section.blocked ? block : 0U), count_size);
      out_.little(0, count_size);  // Reserved, and the memory page.
      contents += 4 * section.words.size();
      relocations += relocation_size() * section.relocations.size();
      lines += line_entry * lines_[i].size();
    }
  }

  void write_relocation(const ObjectSection& section, const Relocation& relocation) {
    out_.u32(section.address + relocation.offset);
    const std::uint32_t symbol = relocation.symbol == Relocation::own_section
                                     ? 0xFFFFFFFF
                                     : symbol_numbers_[static_cast<std::size_t>(relocation.symbol)];
    out_.little(symbol, object_.version == 0 ? 2 : 4);
    out_.u16(relocation.low);
    out_.u16(static_cast<std::uint32_t>(relocation.type));
  }

  /// A name that is too long becomes zeros and its offset among the strings.
  void write_name(const std::string& name, std::size_t size) {
    if (name.size() <= size) return out_.text(name, size);
    out_.u32(0);
    out_.u32(static_cast<std::uint32_t>(4 + strings_.size()));
    out_.text("", size - 8);
    strings_ += name + '\0';
  }

  void write_file(std::size_t number) {
    const bool last = number + 1 == object_.files.size();
    out_.text(".file", 8);
    out_.u32(last ? 0 : static_cast<std::uint32_t>(2 * (number + 1)));  // The symbol of the next file.
    out_.u16(static_cast<std::uint16_t>(debug_section));
    out_.u16(0);
    out_.u8(class_file);
    out_.u8(1);
    write_name(object_.files[number], file_name);
    out_.text("", symbol_entry - file_name);
  }

  void write_symbol(const ObjectSymbol& symbol) {
    write_name(symbol.name, 8);
    out_.u32(symbol.value);
    const int section = symbol.section == ObjectSymbol::absolute    ? absolute_section
                        : symbol.section == ObjectSymbol::undefined ? undefined_section
                                                                    : symbol.section + 1;
    out_.u16(static_cast<std::uint16_t>(section));
    out_.u16(0);
    out_.u8(symbol.global ? class_external : class_static);
    out_.u8(symbol.stands_for_section ? 1 : 0);
    if (!symbol.stands_for_section) return;
    const auto& owner = object_.sections[static_cast<std::size_t>(symbol.section)];
    out_.u32(owner.size);
    out_.u16(static_cast<std::uint32_t>(owner.relocations.size()));
    out_.text("", symbol_entry - 6);
  }

  const Object& object_;
  bool v2_;
  FileBytes out_;
  std::string strings_;
  std::vector<std::vector<LineEntry>> lines_;  ///< By section.
  std::vector<std::uint32_t> symbol_numbers_;
  std::uint32_t symbol_entries_ = 0;
};

/// The section that contains the address, or ObjectSymbol::absolute. A table for the loader is not in memory.
int section_of(const Object& object, Word value) {
  for (std::size_t i = 0; i < object.sections.size(); ++i)
    if (!object.sections[i].table_of_copies && value - object.sections[i].address < object.sections[i].size)
      return static_cast<int>(i);
  return ObjectSymbol::absolute;
}

/// Puts a record back into its table.
void add_record(ObjectSection& table, const Image::Section& record) {
  table.table_of_copies = true;
  table.words.push_back(record.size);
  table.words.push_back(record.address);
  table.words.insert(table.words.end(), record.words.begin(), record.words.end());
}

}  // namespace

Object executable_of(const Image& image) {
  Object out;
  out.executable = true;
  out.cpu = image.cpu;
  out.entry = image.entry;
  std::vector<std::size_t> numbers;  // For each section of the image, its number in the file.
  for (const Image::Section& section : image.sections) {
    if (section.initial_values && !out.sections.empty()) {
      add_record(out.sections.back(), section);
      numbers.push_back(out.sections.size() - 1);
      continue;
    }
    numbers.push_back(out.sections.size());
    ObjectSection& written = out.sections.emplace_back();
    written.name = section.name;
    written.address = section.address;
    written.size = section.size;
    written.words = section.words;
    written.loaded = section.loaded;
    // A section's header has room for eight characters; the whole name is that of the section's symbol, as in objects.
    if (section.name.size() > 8)
      out.symbols.push_back({.name = section.name,
                             .value = section.address,
                             .section = static_cast<int>(out.sections.size()) - 1,
                             .global = false,
                             .stands_for_section = true});
  }
  for (ObjectSection& section : out.sections)
    if (section.table_of_copies) section.words.resize(section.size);
  out.files = image.files;
  for (const LineRecord& line : image.lines) {
    ObjectSection& section = out.sections.at(numbers.at(line.section));
    section.lines.push_back({line.address - section.address, line.file, line.line});
  }
  const auto add = [&](const std::string& name, Word value, bool global) {
    out.symbols.push_back({.name = name,
                           .value = value,
                           .section = section_of(out, value),
                           .global = global,
                           .stands_for_section = false});
  };
  for (const auto& [name, value] : image.symbols) add(name, value, true);
  for (const auto& [name, value] : image.further_symbols) add(name, value, false);
  return out;
}

std::vector<std::byte> coff_bytes(const Object& object) { return CoffWriter(object).write(); }
std::vector<std::byte> coff_bytes(const Image& image) { return coff_bytes(executable_of(image)); }

void write_coff(const Object& object, std::ostream& out) {
  const std::vector<std::byte> bytes = coff_bytes(object);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

void write_coff(const Object& object, const std::filesystem::path& path) {
  io::OutputFile file(path.string());
  write_coff(object, file.stream());
  file.commit();
}

void write_coff(const Image& image, const std::filesystem::path& path) { write_coff(executable_of(image), path); }

}  // namespace toolchain
