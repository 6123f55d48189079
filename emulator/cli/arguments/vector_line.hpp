#pragma once
// One line of a file of single-step vectors: a state, instructions, and the state after these instructions
// (docs/cli.md).
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "io/text_error.hpp"
#include "isa/word.hpp"

namespace cli {

/// The message says what is wrong and what would be right; the caller adds file and line.
class VectorError : public io::TextError<std::runtime_error> {
 public:
  using TextError::TextError;
};

struct Vector {
  /// A register of either file, or the PC.
  struct Place {
    enum class Kind : std::uint8_t { primary, expansion, pc } kind = Kind::pc;
    std::uint8_t code = 0;
    bool operator==(const Place&) const = default;
  };
  struct Setting {
    Place place;
    std::uint64_t value = 0;
  };
  struct Word {
    isa::Address address = 0;
    isa::Word value = 0;
  };
  struct Access {
    isa::Address address = 0;
    bool write = false;
    isa::Word value = 0;  ///< of a write
  };

  std::string id;
  isa::Word status_mask = ~isa::Word{0};  ///< bits of ST to compare
  unsigned steps = 1;
  std::vector<isa::Word> code;  ///< from address 1000h on
  std::vector<Setting> before, after;
  std::vector<Word> memory_before, memory_after;
  std::vector<Access> accesses;  ///< in bus order; empty: the bus is not compared
};

/// Throws VectorError.
Vector parse_vector(std::string_view line);

std::string name(Vector::Place place);

}  // namespace cli
