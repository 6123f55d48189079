#include <fmt/format.h>

#include <cstring>
#include <fstream>

#include "toolchain/coff.hpp"
#include "toolchain/coff_format.hpp"

namespace toolchain {
namespace {

using namespace coff;

class CoffReader {
 public:
  CoffReader(std::span<const std::byte> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  Image read() {
    read_file_header();
    Image image;
    if (optional_size_ >= optional_header) image.entry = u32(header_size_ + 16, "the entry point");
    const std::size_t table = header_size_ + optional_size_;
    for (std::size_t i = 0; i < section_count_; ++i) read_section(image, table + i * section_size_);
    read_symbols(image);
    if (image.sections.empty()) fail("it has no sections");
    return image;
  }

 private:
  [[noreturn]] void fail(const std::string& why) const { throw CoffError(fmt::format("{}: {}", name_, why)); }

  void need(std::uint64_t offset, std::uint64_t size, std::string_view what) const {
    if (offset > bytes_.size() || size > bytes_.size() - offset)
      fail(fmt::format("cut short: {} should be at bytes {} to {}, but the file has {}", what, offset, offset + size,
                       bytes_.size()));
  }

  std::uint32_t little(std::size_t offset, std::size_t size, std::string_view what) const {
    need(offset, size, what);
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) value |= std::to_integer<std::uint32_t>(bytes_[offset + i]) << (8 * i);
    return value;
  }
  std::uint16_t u16(std::size_t offset, std::string_view what) const {
    return static_cast<std::uint16_t>(little(offset, 2, what));
  }
  std::uint32_t u32(std::size_t offset, std::string_view what) const { return little(offset, 4, what); }

  std::string text(std::size_t offset, std::size_t size, std::string_view what) const {
    need(offset, size, what);
    std::string out;
    for (std::size_t i = 0; i < size && bytes_[offset + i] != std::byte{0}; ++i)
      out += printable(static_cast<char>(bytes_[offset + i]));
    return out;
  }

  /// Names go into messages and Python strings; a damaged file may hold anything.
  static char printable(char c) { return c >= ' ' && c <= '~' ? c : '?'; }

  void read_file_header() {
    if (bytes_.size() < file_header_v0) fail(fmt::format("not a COFF file: only {} bytes", bytes_.size()));
    const std::uint16_t magic = u16(0, "the magic number");
    if (magic == target_id) {
      version_ = 0;
    } else if (magic == magic_v1 || magic == magic_v2) {
      version_ = magic == magic_v1 ? 1 : 2;
      const std::uint16_t target = u16(20, "the target");
      if (target != target_id)
        fail(fmt::format("a COFF file for target {:04X}h, not for the C3x/C4x ({:04X}h)", target, target_id));
    } else {
      fail(fmt::format("not a COFF file for the C3x/C4x: it starts with {:04X}h (known are 0093h, 00C1h, 00C2h)",
                       magic));
    }
    const std::uint16_t flags = u16(18, "the flags");
    if ((flags & executable) == 0) fail("an object file that was not linked: only executables can be loaded");
    section_count_ = u16(2, "the number of sections");
    symbols_at_ = u32(8, "the symbol table's place");
    symbol_count_ = u32(12, "the number of symbols");
    optional_size_ = u16(16, "the optional header's size");
    header_size_ = version_ == 0 ? file_header_v0 : file_header_v12;
    section_size_ = version_ == 2 ? section_header_v2 : section_header_v01;
    if (optional_size_ != 0) need(header_size_, optional_size_, "the optional header");
  }

  void read_section(Image& image, std::size_t at) {
    need(at, section_size_, "a section header");
    Image::Section section;
    section.name = text(at, 8, "a section's name");
    section.address = u32(at + 8, "a section's address");
    section.size = u32(at + 16, "a section's size");
    const std::uint32_t where = u32(at + 20, "a section's place");
    const std::uint32_t flags = version_ == 2 ? u32(at + 40, "a section's flags") : u16(at + 36, "a section's flags");
    section.loaded = where != 0 && (flags & (dsect | noload | copy | bss)) == 0;
    bases_.push_back(section.address);
    if (section.size == 0) return;
    if (std::uint64_t{section.address} + section.size > std::uint64_t{1} << 32)
      fail(fmt::format("section '{}' passes the end of the address space", section.name));
    if (section.loaded) {
      need(where, std::uint64_t{4} * section.size, fmt::format("the contents of section '{}'", section.name));
      section.words.reserve(section.size);
      for (std::size_t i = 0; i < section.size; ++i) section.words.push_back(u32(where + 4 * i, "a word"));
    }
    image.sections.push_back(std::move(section));
  }

  void read_symbols(Image& image) {
    if (symbol_count_ == 0) return;
    need(symbols_at_, std::uint64_t{symbol_entry} * symbol_count_, "the symbol table");
    const std::size_t strings = symbols_at_ + symbol_entry * std::size_t{symbol_count_};
    for (std::size_t i = 0; i < symbol_count_; ++i) {
      const std::size_t at = symbols_at_ + symbol_entry * i;
      const auto section = static_cast<std::int16_t>(u16(at + 12, "a symbol's section"));
      const std::size_t auxiliary = little(at + 17, 1, "a symbol's auxiliary count");
      i += auxiliary;
      if (section == undefined_section || section < absolute_section) continue;
      if (section > static_cast<int>(bases_.size()))
        fail(fmt::format("a symbol lies in section {} of {}", section, bases_.size()));
      const std::string name = symbol_name(at, strings);
      if (!name.empty()) image.symbols.insert_or_assign(name, u32(at + 8, "a symbol's value"));
    }
  }

  std::string symbol_name(std::size_t at, std::size_t strings) const {
    if (u32(at, "a symbol's name") != 0) return text(at, 8, "a symbol's name");
    const std::uint32_t offset = u32(at + 4, "a symbol's name");
    const std::uint32_t size = u32(strings, "the string table");
    need(strings, size, "the string table");
    if (offset < 4 || offset >= size)
      fail(fmt::format("a symbol's name lies at {} in a string table of {} bytes", offset, size));
    return text(strings + offset, size - offset, "a symbol's name");
  }

  std::span<const std::byte> bytes_;
  const std::string& name_;
  int version_ = 0;
  std::size_t header_size_ = 0, section_size_ = 0, optional_size_ = 0;
  std::size_t section_count_ = 0, symbol_count_ = 0, symbols_at_ = 0;
  std::vector<Address> bases_;
};

}  // namespace

Image read_coff(std::span<const std::byte> bytes, const std::string& name) { return CoffReader(bytes, name).read(); }

Image read_coff(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw CoffError(fmt::format("{}: a directory", path.string()));
  std::ifstream stream(path, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  if (!stream) throw CoffError(fmt::format("{}: cannot be read", path.string()));
  return read_coff(std::as_bytes(std::span(bytes)), path.string());
}

}  // namespace toolchain
