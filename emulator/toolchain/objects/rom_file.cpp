#include "toolchain/objects/rom_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "io/input_file.hpp"
#include "isa/ascii.hpp"

namespace toolchain {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t bytes_per_line = 32;
constexpr std::uint64_t largest = std::uint64_t{64} << 20;
constexpr std::uint8_t erased = 0xFF;

std::string hex_of(std::span<const std::uint8_t> bytes) {
  std::string out;
  for (const std::uint8_t byte : bytes) out += fmt::format("{:02X}", byte);
  return out;
}

unsigned sum_of(std::span<const std::uint8_t> bytes) {
  unsigned sum = 0;
  for (const std::uint8_t byte : bytes) sum += byte;
  return sum & 0xFF;
}

std::uint8_t byte_of(std::uint64_t value, unsigned place) { return static_cast<std::uint8_t>(value >> 8 * place); }

std::string intel_line(std::uint8_t type, std::uint16_t address, std::span<const std::uint8_t> data) {
  Bytes line{static_cast<std::uint8_t>(data.size()), byte_of(address, 1), byte_of(address, 0), type};
  line.insert(line.end(), data.begin(), data.end());
  line.push_back(static_cast<std::uint8_t>(0x100 - sum_of(line)));
  return ":" + hex_of(line) + "\n";
}

std::string s_line(char type, std::uint32_t address, std::span<const std::uint8_t> data) {
  Bytes line{static_cast<std::uint8_t>(data.size() + 5)};
  for (unsigned place = 4; place-- > 0;) line.push_back(byte_of(address, place));
  line.insert(line.end(), data.begin(), data.end());
  line.push_back(static_cast<std::uint8_t>(0xFF - sum_of(line)));
  return fmt::format("S{}{}\n", type, hex_of(line));
}

/// The bytes of the lines of a text, by address.
class Collected {
 public:
  void add(std::uint64_t address, std::span<const std::uint8_t> data) {
    for (std::size_t i = 0; i < data.size(); ++i)
      if (!bytes_.emplace(address + i, data[i]).second)
        throw RomError(fmt::format("address {:X}h has a byte already", address + i));
    if (!bytes_.empty() && bytes_.rbegin()->first - bytes_.begin()->first >= largest)
      throw RomError(fmt::format("the addresses span more than {} MiB", largest >> 20));
  }
  Bytes all() const {
    if (bytes_.empty()) throw RomError("contains no byte");
    const std::uint64_t first = bytes_.begin()->first;
    Bytes out(bytes_.rbegin()->first - first + 1, erased);
    for (const auto& [address, byte] : bytes_) out[address - first] = byte;
    return out;
  }

 private:
  std::map<std::uint64_t, std::uint8_t> bytes_;
};

Bytes digits(std::string_view text) {
  const auto nibble = [](char c) -> unsigned {
    if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
    const char lower = ascii::lower(c);
    if (lower >= 'a' && lower <= 'f') return static_cast<unsigned>(lower - 'a' + 10);
    throw RomError(fmt::format("'{}' is no hexadecimal digit", c));
  };
  if (text.size() % 2 != 0) throw RomError("an odd number of digits");
  Bytes out;
  for (std::size_t i = 0; i < text.size(); i += 2)
    out.push_back(static_cast<std::uint8_t>(nibble(text[i]) << 4 | nibble(text[i + 1])));
  return out;
}

void check_length(const Bytes& line, std::size_t expected) {
  if (line.size() != expected)
    throw RomError(fmt::format("{} bytes; by its count {} are expected", line.size(), expected));
}

void check_sum(const Bytes& line, unsigned whole) {
  const unsigned expected = (whole - sum_of(std::span(line).first(line.size() - 1))) & 0xFF;
  if (line.back() != expected)
    throw RomError(fmt::format("the checksum is {:02X}h; {:02X}h is expected", line.back(), expected));
}

/// A line of Intel hex. True: it was the last.
class IntelLines {
 public:
  bool read(std::string_view text, Collected& out) {
    if (!text.starts_with(':')) throw RomError("a line of Intel hex begins with ':'");
    const Bytes line = digits(text.substr(1));
    if (line.size() < 5) throw RomError("a line of Intel hex has at least 5 bytes");
    check_length(line, line[0] + 5U);
    check_sum(line, 0x100);
    const std::span data = std::span(line).subspan(4, line[0]);
    const std::uint64_t address = std::uint64_t{line[1]} << 8 | line[2];
    const auto word = [&] {
      if (data.size() != 2) throw RomError("an address record holds 2 bytes");
      return std::uint64_t{data[0]} << 8 | data[1];
    };
    switch (line[3]) {
      case 0: out.add(base_ + address, data); return false;
      case 1: return true;
      case 2: base_ = word() << 4; return false;
      case 4: base_ = word() << 16; return false;
      case 3:
      case 5: return false;  // a start address: not used here
      default: throw RomError(fmt::format("record type {:02X}h; 0 to 5 are known", line[3]));
    }
  }

 private:
  std::uint64_t base_ = 0;
};

class SLines {
 public:
  bool read(std::string_view text, Collected& out) {
    if (text.size() < 4 || text[0] != 'S' || text[1] < '0' || text[1] > '9' || text[1] == '4')
      throw RomError("a line begins with S0 to S9, not S4");
    const Bytes line = digits(text.substr(2));
    check_length(line, line[0] + 1U);
    check_sum(line, 0xFF);
    const char type = text[1];
    if (type >= '7') return true;
    if (type == '5' || type == '6') return count(std::span(line).subspan(1, line.size() - 2)), false;
    if (type < '1' || type > '3') return false;  // a header
    ++lines_;
    const std::size_t address_bytes = static_cast<std::size_t>(type - '0') + 1;
    if (line.size() < address_bytes + 2) throw RomError("the line ends within its address");
    std::uint64_t address = 0;
    for (std::size_t i = 0; i < address_bytes; ++i) address = address << 8 | line[1 + i];
    out.add(address, std::span(line).subspan(1 + address_bytes, line.size() - address_bytes - 2));
    return false;
  }

 private:
  void count(std::span<const std::uint8_t> given) const {
    std::uint64_t said = 0;
    for (const std::uint8_t byte : given) said = said << 8 | byte;
    if (said != lines_) throw RomError(fmt::format("{} lines of data before this count, which says {}", lines_, said));
  }
  std::uint64_t lines_ = 0;
};

std::string_view without_blanks(std::string_view line) {
  const auto is_blank = [](char c) { return ascii::is_space(c) || c == '\x1A'; };
  while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  return line;
}

/// Whether the first line that is not blank begins like Intel hex, or like S-records.
bool begins_with_intel(std::string_view line) { return line.starts_with(':'); }
bool begins_with_s(std::string_view line) { return line.size() > 1 && line[0] == 'S' && ascii::is_digit(line[1]); }

template <class Lines>
Bytes read_lines(std::string_view text, const std::string& name) {
  Lines lines;
  Collected out;
  std::size_t number = 0;
  bool ended = false;
  try {
    while (!text.empty()) {
      ++number;
      const auto end = text.find('\n');
      const std::string_view line = without_blanks(text.substr(0, end));
      text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
      if (ended && (begins_with_intel(line) || begins_with_s(line)))
        throw RomError("a record after the last one: two images in one file");
      if (!ended && !line.empty()) ended = lines.read(line, out);
    }
    if (!ended) throw RomError("the file ends without its last record: it is cut short");
    return out.all();
  } catch (const RomError& error) {
    throw RomError(fmt::format("{}:{}: {}", name, number, error.what()));
  }
}

}  // namespace

std::string rom_file(std::span<const std::uint8_t> bytes, RomFormat format) {
  if (format == RomFormat::binary) return {bytes.begin(), bytes.end()};
  std::string out;
  std::uint64_t upper = 0;
  for (std::size_t at = 0; at < bytes.size(); at += bytes_per_line) {
    const auto data = bytes.subspan(at, std::min(bytes_per_line, bytes.size() - at));
    if (format == RomFormat::srec) {
      out += s_line('3', static_cast<std::uint32_t>(at), data);
      continue;
    }
    if (at >> 16 != upper) {
      upper = at >> 16;
      const Bytes word{byte_of(upper, 1), byte_of(upper, 0)};
      out += intel_line(4, 0, word);
    }
    out += intel_line(0, static_cast<std::uint16_t>(at & 0xFFFF), data);
  }
  return out + (format == RomFormat::srec ? s_line('7', 0, {}) : intel_line(1, 0, {}));
}

Bytes read_rom(const std::filesystem::path& path) {
  const io::Input input = io::read_input(path);
  if (!input.problem.empty())
    throw RomError(
        fmt::format("{}: {}; a file in Intel hex, S-records or bytes is expected", path.string(), input.problem));
  const std::string_view text = input.text;
  // Blank lines may come first. A file of plain bytes that begins like this, with such a character next, is not a boot
  // image.
  const std::string_view first = without_blanks(text);
  if (begins_with_intel(first)) return read_lines<IntelLines>(text, path.string());
  if (begins_with_s(first)) return read_lines<SLines>(text, path.string());
  if (text.empty()) throw RomError(fmt::format("{}: contains no byte", path.string()));
  return {text.begin(), text.end()};
}

std::vector<isa::Word> read_rom_words(const std::filesystem::path& path, std::optional<unsigned> width,
                                      std::string_view width_name) {
  return rom_words_of(path, read_rom(path), width, width_name);
}

std::vector<isa::Word> rom_words_of(const std::filesystem::path& path, std::span<const std::uint8_t> bytes,
                                    std::optional<unsigned> width, std::string_view width_name) {
  if (!width) width = boot_width(bytes);
  if (!width)
    throw RomError(fmt::format(
        "{}: its first word is not 8, 16 or 32, so it does not say how wide it is; {} is expected: 8, 16 or 32",
        path.string(), width_name));
  if (*width != 8 && *width != 16 && *width != 32)
    throw RomError(fmt::format("{}: {} {}: 8, 16 or 32 is expected", path.string(), width_name, *width));
  if (const std::size_t left = bytes.size() % (*width / 8); left != 0)
    throw RomError(fmt::format("{}: its {} bytes are no whole number of words of {} bits: the last has {} of {} bytes",
                               path.string(), bytes.size(), *width, left, *width / 8));
  return rom_words(bytes, *width);
}

std::string width_contradiction(std::span<const std::uint8_t> bytes, std::optional<unsigned> width,
                                std::string_view width_name) {
  const auto said = boot_width(bytes);
  if (!said || !width || *said == *width) return {};
  return fmt::format("its first word says {} bits, as to a boot loader, and {} {}", *said, width_name, *width);
}

std::vector<isa::Word> rom_words(std::span<const std::uint8_t> bytes, unsigned width) {
  const std::size_t each = width / 8;
  std::vector<isa::Word> words((bytes.size() + each - 1) / each);
  for (std::size_t i = 0; i < bytes.size(); ++i) words[i / each] |= isa::Word{bytes[i]} << 8 * (i % each);
  return words;
}

Bytes rom_bytes(std::span<const isa::Word> words) {
  Bytes out;
  for (const isa::Word word : words)
    for (unsigned place = 0; place < 4; ++place) out.push_back(byte_of(word, place));
  return out;
}

std::optional<unsigned> boot_width(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 4 || bytes[1] != 0 || bytes[2] != 0 || bytes[3] != 0) return std::nullopt;
  return bytes[0] == 8 || bytes[0] == 16 || bytes[0] == 32 ? std::optional<unsigned>(bytes[0]) : std::nullopt;
}

}  // namespace toolchain
