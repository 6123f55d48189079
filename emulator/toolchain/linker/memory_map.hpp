#pragma once
// Where the linker may put sections: a TOML file (docs/assembler.md, "The linker").
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "io/text_error.hpp"
#include "isa/word.hpp"

namespace toolchain {

/// A memory map that cannot be used; the message names the file and the line of each error.
class MemoryMapError : public io::TextError<std::runtime_error> {
 public:
  using TextError::TextError;
};

struct MemoryMap {
  struct Memory {
    std::string name;
    isa::Address origin = 0;
    std::uint64_t length = 0;  ///< In words; up to 2^32.
  };
  struct Placement {
    std::string section;
    std::string memory;  ///< Empty if only an address is given: the memory in which it is, or none.
    std::optional<isa::Address> address;
    isa::Address alignment = 1;
    isa::Address size = 0;  ///< At least this number of words; words without contents are reserved.
  };

  std::vector<Memory> memories;
  std::vector<Placement> sections;  ///< In the order of the file.
  std::string others;               ///< The memory of sections that are not named.
  std::map<std::string, isa::Word, std::less<>> symbols;
  std::string entry;  ///< A symbol, or empty.
  /// What sets the initial values of C variables, the table .cinit: the program, from a table in memory (ROM model,
  /// TI's -c), or the loader (RAM model, TI's -cr).
  bool loader_sets_values = false;
  bool is_c = false;  ///< One of the two is asked for, so the program starts at _c_int00, of a library if need be.

  const Memory* memory(std::string_view name) const;
  const Memory* memory_at(isa::Address address) const;

  /// One memory, `local`: a megaword from 300000h on, as on the board `default`.
  static MemoryMap standard();
};

/// The C model of that name, `rom` or `ram`, as a value of MemoryMap::loader_sets_values; none for another name.
std::optional<bool> c_model(std::string_view name);

/// `name` is the name of the text in messages. Throws MemoryMapError.
MemoryMap parse_memory_map(std::string_view toml, const std::string& name);
MemoryMap read_memory_map(const std::filesystem::path& path);

}  // namespace toolchain
