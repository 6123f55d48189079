#include "machine/chips/boot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "c40/peripherals/link.hpp"
#include "c40_programs/image.hpp"
#include "toolchain/objects/coff.hpp"

namespace machine {
namespace {

using c40::Address;
using c40::Word;

constexpr Word memory_width = 32, end_of_blocks = 0;
constexpr Word from_ports = 7;
/// By the levels of pins IIOF3 to IIOF1 (c40-hardware.md 9.1).
constexpr std::array<Address, 7> sources{0,           0xC0000000u, 0xA0000000u, 0x80000000u,
                                         0x60000000u, 0x40000000u, 0x00300000u};

c40::Board with_rom(c40::Board board, Word code) {
  static const toolchain::Image rom = toolchain::read_coff(c40_programs::built_in_boot_rom());
  board.rom = rom.sections.at(0).words;
  board.pins = {0, code << 1 | 1};
  return board;
}

void add_block(std::vector<Word>& stream, Address address, std::span<const Word> words) {
  if (words.empty()) return;
  stream.push_back(static_cast<Word>(words.size()));
  stream.push_back(address);
  stream.insert(stream.end(), words.begin(), words.end());
}

}  // namespace

c40::Board with_boot_from_port(c40::Board board) { return with_rom(std::move(board), from_ports); }

c40::Board with_boot_from_memory(c40::Board board, Address address) {
  const auto found = std::find(sources.begin() + 1, sources.end(), address);
  if (found == sources.end())
    throw std::invalid_argument(
        fmt::format("the pins choose no memory at {:08X}h; they choose 00300000h, 40000000h, 60000000h, 80000000h, "
                    "A0000000h or C0000000h",
                    address));
  return with_rom(std::move(board), static_cast<Word>(found - sources.begin()));
}

ResetSource reset_source(const c40::Board& board) {
  if (board.rom.empty() || board.pins.reset_location != 0) return ResetSource::vector;
  return board.pins.iiof >> 1 == from_ports ? ResetSource::ports : ResetSource::memory;
}
Address boot_address(const c40::Board& board) { return sources.at(board.pins.iiof >> 1); }

std::vector<Word> boot_stream(const toolchain::Image& image, const BootHeader& header) {
  toolchain::require_c40(image);
  std::vector<Word> stream{header.global_interface_control, header.local_interface_control}, others;
  bool entered = false;
  for (const toolchain::Image::Section& section : image.sections) {
    if (!section.loaded || section.words.empty()) continue;
    if (section.address < c40::rom_words)
      throw std::invalid_argument(
          fmt::format("section {} at {:08X}h cannot be booted: the boot ROM is there", section.name, section.address));
    const std::span<const Word> words = section.words;
    const Address into = image.entry - section.address;
    if (into < words.size()) {
      entered = true;
      add_block(stream, image.entry, words.subspan(into));
      add_block(others, section.address, words.first(into));
    } else {
      add_block(others, section.address, words);
    }
  }
  if (!entered) throw std::invalid_argument(fmt::format("the program's entry {:08X}h is in no section", image.entry));
  stream.insert(stream.end(), others.begin(), others.end());
  stream.insert(stream.end(), {end_of_blocks, header.ivtp, header.tvtp, header.acknowledge});
  return stream;
}

std::vector<Word> boot_memory(const toolchain::Image& image, const BootHeader& header) {
  std::vector<Word> stream = boot_stream(image, header);
  stream.insert(stream.begin(), memory_width);
  return stream;
}

void require_not_overwritten(std::span<const Word> stream, Address at, const toolchain::Image& image) {
  constexpr std::size_t header_words = 3;
  for (std::size_t next = header_words; stream[next] != end_of_blocks;) {
    const Word words = stream[next];
    Address into = stream[next + 1];
    next += 2;
    for (const std::size_t end = next + words; next < end; ++next, ++into) {
      const std::size_t hit = into - at;
      if (hit <= next || hit >= stream.size()) continue;
      const auto section = std::ranges::find_if(image.sections, [&](const toolchain::Image::Section& s) {
        return s.loaded && into - s.address < s.words.size();
      });
      throw std::invalid_argument(
          fmt::format("section {} has a word at {:08X}h, where the boot loader has not read the stream ({:08X}h to "
                      "{:08X}h) yet; the program has to lie elsewhere, or to come through a port",
                      section->name, into, at, at + stream.size() - 1));
    }
  }
}

BootFeeder::BootFeeder(c40::Chip& chip, int port, std::vector<Word> stream)
    : chip_(chip), port_(port), stream_(std::move(stream)) {
  if (!stream_.empty()) chip_.port(port_).receive(stream_[sent_++]);
}

bool BootFeeder::serve(const c40::PortAccess& access) {
  if (access.port != port_ || access.write || sent_ == stream_.size()) return false;
  const c40::Cycles at = std::max(access.cycle, next_);
  chip_.port(port_).receive(stream_[sent_++]);
  chip_.complete_port(at);
  next_ = at + c40::LinkParameters{}.word_cycles;
  return true;
}

}  // namespace machine
