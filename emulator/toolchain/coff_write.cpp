#include <fmt/format.h>

#include <fstream>

#include "toolchain/coff.hpp"
#include "toolchain/coff_format.hpp"

namespace toolchain {
namespace {

using namespace coff;

class Bytes {
 public:
  void little(std::uint32_t value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) out_.push_back(static_cast<std::byte>(value >> (8 * i)));
  }
  void u8(std::uint32_t value) { little(value, 1); }
  void u16(std::uint32_t value) { little(value, 2); }
  void u32(std::uint32_t value) { little(value, 4); }
  /// Exactly `size` bytes, cut or filled with zeros.
  void text(std::string_view value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
      out_.push_back(i < value.size() ? static_cast<std::byte>(value[i]) : std::byte{0});
  }
  std::size_t size() const { return out_.size(); }
  std::vector<std::byte> take() { return std::move(out_); }

 private:
  std::vector<std::byte> out_;
};

std::uint32_t section_flags(const Image::Section& section) {
  if (!section.loaded) return bss;
  return section.name == ".text" ? text : data;
}

/// Number of the section that holds the address (from 1), or -1: the value is absolute.
std::int16_t section_of(const Image& image, Word value) {
  for (std::size_t i = 0; i < image.sections.size(); ++i)
    if (value - image.sections[i].address < image.sections[i].size) return static_cast<std::int16_t>(i + 1);
  return absolute_section;
}

Address total(const Image& image, std::uint32_t flag) {
  Address words = 0;
  for (const auto& section : image.sections)
    if (section_flags(section) == flag) words += section.size;
  return words;
}

Address start(const Image& image, std::uint32_t flag) {
  for (const auto& section : image.sections)
    if (section_flags(section) == flag) return section.address;
  return 0;
}

void write_headers(Bytes& out, const Image& image, std::size_t contents_at, std::size_t symbols_at) {
  out.u16(magic_v2);
  out.u16(static_cast<std::uint32_t>(image.sections.size()));
  out.u32(0);  // No time stamp: equal programs give equal files.
  out.u32(static_cast<std::uint32_t>(symbols_at));
  out.u32(static_cast<std::uint32_t>(image.symbols.size()));
  out.u16(optional_header);
  out.u16(no_relocations | executable | no_line_numbers | c4x | little_endian);
  out.u16(target_id);
  out.u16(optional_magic);
  out.u16(0);
  for (const std::uint32_t flag : {text, data, bss}) out.u32(total(image, flag));
  out.u32(image.entry);
  for (const std::uint32_t flag : {text, data}) out.u32(start(image, flag));
  for (const Image::Section& section : image.sections) {
    out.text(section.name, 8);
    out.u32(section.address);
    out.u32(section.address);
    out.u32(section.size);
    out.u32(section.loaded ? static_cast<std::uint32_t>(contents_at) : 0);
    if (section.loaded) contents_at += 4 * section.words.size();
    for (int i = 0; i < 4; ++i) out.u32(0);  // Neither relocations nor line numbers.
    out.u32(section_flags(section));
    out.u16(0);
    out.u16(0);
  }
}

void write_symbols(Bytes& out, const Image& image) {
  std::string strings;
  for (const auto& [name, value] : image.symbols) {
    if (name.size() <= 8) {
      out.text(name, 8);
    } else {
      out.u32(0);
      out.u32(static_cast<std::uint32_t>(4 + strings.size()));
      strings += name + '\0';
    }
    out.u32(value);
    out.u16(static_cast<std::uint16_t>(section_of(image, value)));
    out.u16(0);
    out.u8(class_external);
    out.u8(0);
  }
  out.u32(static_cast<std::uint32_t>(4 + strings.size()));
  out.text(strings, strings.size());
}

}  // namespace

std::vector<std::byte> coff_bytes(const Image& image) {
  if (image.sections.size() > most_sections)
    throw std::runtime_error(
        fmt::format("a COFF file holds {} sections, not {}", most_sections, image.sections.size()));
  std::size_t words = 0;
  for (const auto& section : image.sections) words += section.loaded ? section.words.size() : 0;
  const std::size_t contents_at = file_header_v12 + optional_header + section_header_v2 * image.sections.size();
  Bytes out;
  write_headers(out, image, contents_at, contents_at + 4 * words);
  for (const auto& section : image.sections)
    if (section.loaded)
      for (const Word word : section.words) out.u32(word);
  write_symbols(out, image);
  return out.take();
}

void write_coff(const Image& image, const std::filesystem::path& path) {
  const auto bytes = coff_bytes(image);
  const std::filesystem::path temporary = path.string() + ".tmp";
  {
    std::ofstream stream(temporary, std::ios::binary);
    stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream) {
      std::error_code ignored;
      std::filesystem::remove(temporary, ignored);
      throw std::runtime_error(fmt::format("cannot write '{}'", path.string()));
    }
  }
  std::error_code error;
  std::filesystem::rename(temporary, path, error);
  if (error) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    throw std::runtime_error(fmt::format("cannot write '{}': {}", path.string(), error.message()));
  }
}

}  // namespace toolchain
