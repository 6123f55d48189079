#pragma once
// The contents of a TI COFF file: sections, symbols, relocations (c40-hardware.md 10.1), for relocatable objects and
// executables.
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "toolchain/objects/image.hpp"

namespace toolchain {

/// The numbers of the file format.
enum class RelocationType : std::uint16_t {
  rel24 = 5,      ///< 24 bits
  relword = 16,   ///< 16 bits
  rellong = 17,   ///< the whole word
  pcrword = 19,   ///< 16 bits, relative to the word's own address
  pcr24 = 21,     ///< 24 bits, relative to the word's own address
  partls16 = 32,  ///< the low half of an address
  partms16 = 33,  ///< the high half of an address
};
std::optional<RelocationType> relocation_type(std::uint16_t number);
std::string_view name(RelocationType type);  ///< The name in the format's description: "R_PCR24".
/// Number of low bits of the word that the relocation fills.
unsigned width(RelocationType type);
bool is_relative(RelocationType type);

struct Relocation {
  static constexpr int own_section = -1;

  Address offset = 0;  ///< Offset of the word from the start of its section.
  RelocationType type = RelocationType::rellong;
  int symbol = own_section;  ///< Index into Object::symbols; or own_section: only the move of the section counts.
  Word low = 0;              ///< partms16: the low half of the address, 0 if not known.
};

struct ObjectSymbol {
  static constexpr int absolute = -1, undefined = -2;

  std::string name;
  Word value = 0;  ///< Address; for an undefined symbol the number of words of common storage that it requests, or 0.
  int section = absolute;  ///< Index into Object::sections.
  bool global = false;
  bool stands_for_section = false;
  bool defines() const { return global && section != undefined; }  ///< for all objects
};

/// The source line of a word.
struct ObjectLine {
  Address offset = 0;      ///< From the start of its section.
  std::uint32_t file = 0;  ///< Index into Object::files.
  int line = 0;            ///< Counted from 1.
};

struct ObjectSection {
  std::string name;
  Address address = 0;
  Address size = 0;         ///< In words.
  std::vector<Word> words;  ///< `size` words if loaded, else none.
  bool loaded = true;
  bool table_of_copies = false;  ///< A .cinit for the loader (COPY): `words` has its contents, `loaded` is false.
  Address alignment = 1;         ///< Power of 2.
  bool blocked = false;          ///< Must not be split over two pages if it fits into one.
  std::vector<Relocation> relocations;
  std::vector<ObjectLine> lines;  ///< By rising offset.
};

struct Object {
  std::string name;  ///< The file's name in messages.
  int version = 2;
  isa::Cpu cpu = isa::Cpu::c40;
  bool executable = false;
  Address entry = 0;
  std::vector<ObjectSection> sections;
  std::vector<ObjectSymbol> symbols;
  std::vector<std::string> files;  ///< The files of `lines`.
};

/// The name of a local symbol that only a relocation needs: "lib+1h" for a place in a section, "=300h" for a number. No
/// source can write it, so it ends with the relocation.
std::string name_for_relocations(const Object& object, int section, Word value);
/// Whether the symbol has a value and a name that a source or a compiler gave it.
bool names_a_value(const Object& object, const ObjectSymbol& symbol);

/// Does what a loader does with a .cinit of the RAM model: a section for each record {count, address, words...}, up to
/// a count of 0. Returns the place of this 0, the number of words if there is none. `file` is the file's name in
/// messages. Throws CoffError if a record extends beyond the table's end.
std::size_t add_initial_values(Image& image, const std::string& table, const std::vector<Word>& records,
                               const std::string& file);
/// Throws CoffError if two loaded sections overlap; `file` is the file's name in the message.
void check_overlaps(const Image& image, const std::string& file);
/// The program that a loader makes of an executable. Throws CoffError if two loaded sections overlap, or if .cinit ends
/// within a record.
Image image_of(const Object& executable);
/// The executable file of a program, with all symbols and lines.
Object executable_of(const Image& image);

}  // namespace toolchain
