// Images of EPROMs: Intel hex, S-records and bytes as they are read, and those that `emulator image` makes of a
// program.
#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "fuzz/target.hpp"
#include "isa/ascii.hpp"
#include "machine/chips/boot.hpp"
#include "toolchain/objects/rom_file.hpp"

namespace {

using Bytes = std::vector<std::uint8_t>;
using toolchain::RomFormat;

const std::string& written(std::string_view text) {
  static const fuzz::InputFile file("image.rom");
  return file.write(text);
}

/// Data written in a format are read back unchanged. Plain bytes that look like another format are read as that format.
void expect_same_back(const Bytes& bytes) {
  if (bytes.empty()) return;
  for (const RomFormat format : {RomFormat::intel_hex, RomFormat::srec, RomFormat::binary}) {
    const bool looks_like_text =
        bytes[0] == ':' || (bytes[0] == 'S' && bytes.size() > 1 && ascii::is_digit(static_cast<char>(bytes[1])));
    if (format == RomFormat::binary && looks_like_text) continue;
    fuzz::expect(toolchain::read_rom(written(toolchain::rom_file(bytes, format))) == bytes,
                 "an image is read back as another one");
  }
}

/// Words are those of the bytes, whatever the memory's width.
void expect_words(const Bytes& bytes) {
  for (const unsigned width : {8U, 16U, 32U}) {
    const auto words = toolchain::rom_words(bytes, width);
    fuzz::expect(words.size() == (bytes.size() + width / 8 - 1) / (width / 8), "words are missing");
    fuzz::expect(width == 32 || std::ranges::all_of(words, [&](isa::Word w) { return w >> width == 0; }),
                 "a word is wider than its memory");
  }
  const Bytes again = toolchain::rom_bytes(toolchain::rom_words(bytes, 32));
  fuzz::expect(std::ranges::equal(std::span(again).first(bytes.size()), bytes), "bytes are lost in words");
}

/// A program of two sections, and the stream that boots it.
void make_image(fuzz::Input input) {
  toolchain::Image image;
  image.cpu = (input.byte() & 7) == 7 ? isa::Cpu::c3x : isa::Cpu::c40;
  const unsigned width = 8U << input.byte() % 3;
  image.entry = input.word();
  for (int n = 0; n < 2; ++n) {
    toolchain::Image::Section section{".text", input.word(), 0, {}, true};
    for (int left = input.byte() % 32; left > 0 && !input.empty(); --left) section.words.push_back(input.word());
    section.size = static_cast<toolchain::Address>(section.words.size());
    image.sections.push_back(std::move(section));
  }
  fuzz::done<std::invalid_argument>([&] {
    std::vector<isa::Word> stream = machine::boot_memory(image, {});
    fuzz::expect(image.cpu == isa::Cpu::c40, "a program of the C3x becomes an image");
    stream.front() = width;
    const Bytes bytes = toolchain::rom_bytes(stream);
    fuzz::expect(toolchain::boot_width(bytes) == width, "an image does not say its width");
    expect_same_back(bytes);
  });
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 8192, most_read = 1 << 20;
  if (size > most) return 0;
  fuzz::Input input(data, size);
  if ((input.byte() & 1) != 0) {
    make_image(input);
    return 0;
  }
  fuzz::done<toolchain::RomError>([&] {
    const Bytes bytes = toolchain::read_rom(written(input.text()));
    fuzz::expect(!bytes.empty(), "an image of no byte");
    if (bytes.size() > most_read) return;  // Far addresses, and FFh between them.
    expect_words(bytes);
    if (bytes.size() <= most) expect_same_back(bytes);
  });
  return 0;
}
