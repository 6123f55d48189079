#pragma once
// A program with assigned addresses: the result of the assembler, linker and COFF reader, which a chip loads.
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "isa/word.hpp"

namespace toolchain {

using isa::Address;
using isa::Word;

/// The source line of a word.
struct LineRecord {
  Address address = 0;
  std::uint32_t file = 0;  ///< Index into Image::files.
  int line = 0;            ///< Counted from 1.
  std::string text;
  std::uint32_t section = 0;  ///< Index into Image::sections.
  std::string second;         ///< For a parallel instruction the line with the bars; else empty.
};

struct Image {
  struct Section {
    std::string name;
    Address address = 0;
    Address size = 0;  ///< In words.
    std::vector<Word>
        words;  ///< `size` words if the section is loaded, none if it is only reserved memory (.bss, .usect).
    bool loaded = true;
    bool initial_values = false;  ///< A record of .cinit for the loader (RAM model): it belongs to the table before it.
  };

  isa::Cpu cpu = isa::Cpu::c40;   ///< The processor of the words.
  std::vector<Section> sections;  ///< Only those that are not empty.
  /// Labels and `.set` constants; for a float, its word in TI's single precision.
  std::map<std::string, Word, std::less<>> symbols;
  /// Further values of names in `symbols`: local symbols of a program's other objects. A name alone means `symbols`.
  std::multimap<std::string, Word, std::less<>> further_symbols;
  Address entry = 0;
  std::vector<std::string> files;  ///< The files of `lines`.
  std::vector<std::string>
      files_read;                 ///< All files: the source and the files that it includes, in the order of reading.
  std::vector<LineRecord> lines;  ///< By rising address within each section; empty if there are none.
  /// For the listing's head: the dialect of each file and why: "ti: the default". First the program, then included
  /// files with a dialect of their own.
  std::vector<std::string> dialects;
  std::vector<std::string> warnings;  ///< In the format of the errors of AssemblyError.

  /// Adds a symbol, as a further one if its name has another value already.
  void add_symbol(const std::string& name, Word value);
  /// All names and values, by name; of one name, that of `symbols` first.
  std::vector<std::pair<std::string_view, Word>> names() const;
  /// The value of a symbol. Throws std::out_of_range with the symbol's name if there is none.
  Word symbol(std::string_view name) const;
  /// The word at an address of a loaded section, or null.
  Word* word_at(Address address);
};

/// The program is for another processor than the emulated one.
class WrongProcessor : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// To be called before a program is put on a chip or into a boot image. `name` is the program's name in the message.
/// \throws WrongProcessor unless the program is for the C40.
void require_c40(const Image& image, std::string_view name = "the program");

/// An address as a user writes it: a symbol of the image, if an image is given, else 300000h, 0x300000 or a decimal
/// number.
std::optional<Address> find_address(std::string_view text, const Image* image);
/// What is wrong with a text that is no address, and the nearest symbol of the image, if one is near.
std::string no_address(std::string_view text, const Image* image);

/// Address, word and source of every line, as text.
std::string listing(const Image& image);

}  // namespace toolchain
