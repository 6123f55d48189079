#pragma once
// A program with its addresses settled: what the assembler and the COFF reader give and what a chip loads.
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "isa/types.hpp"

namespace toolchain {

using isa::Address;
using isa::Word;

/// The source line that a word came from.
struct LineRecord {
  Address address = 0;
  std::uint32_t file = 0;  ///< Index into Image::files.
  int line = 0;            ///< Counted from 1.
  std::string text;
  std::uint32_t section = 0;  ///< Index into Image::sections.
  std::string second;         ///< Of a parallel instruction, the line with the bars; else empty.
};

struct Image {
  struct Section {
    std::string name;
    Address address = 0;
    Address size = 0;  ///< In words.
    std::vector<Word>
        words;  ///< `size` words if the section is loaded, none if it is only reserved memory (.bss, .usect).
    bool loaded = true;
    bool initial_values = false;  ///< A record of .cinit that the loader works off (RAM model): of the table before it.
  };

  isa::Cpu cpu = isa::Cpu::c40;   ///< Whose instructions the words are.
  std::vector<Section> sections;  ///< Only those that are not empty.
  /// Labels and `.set` constants; those that are floats hold their TI single-precision word.
  std::map<std::string, Word, std::less<>> symbols;
  Address entry = 0;
  std::vector<std::string> files;       ///< That `lines` are of.
  std::vector<std::string> files_read;  ///< All: the source and what it includes, in the order of reading.
  std::vector<LineRecord> lines;        ///< By rising address within each section; empty if the origin has none.
  /// How the source was read, and why, for the listing's head: "ti: the default". First the program, then included
  /// files that say it themselves.
  std::vector<std::string> dialects;
  std::vector<std::string> warnings;  ///< Formatted like the errors of AssemblyError.

  /// The value of a symbol. Throws std::out_of_range with the symbol's name if there is none.
  Word symbol(std::string_view name) const;
  /// The word at an address of a loaded section, or null.
  Word* word_at(Address address);
};

/// A program of another processor than the one that runs here.
class WrongProcessor : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// What whoever puts a program on a chip, or makes an image to boot of it, asks first. `name` stands for it in the
/// message. \throws WrongProcessor unless it is the C40's.
void require_c40(const Image& image, std::string_view name = "the program");

/// An address as a user writes it: a symbol of the image, if one is given, else 300000h, 0x300000 or a decimal number.
std::optional<Address> find_address(std::string_view text, const Image* image);

/// Address, word and source of every line, as text.
std::string listing(const Image& image);

}  // namespace toolchain
