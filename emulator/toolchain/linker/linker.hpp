#pragma once
// Links objects and libraries to a program with assigned addresses (docs/assembler.md, "The linker").
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "toolchain/linker/memory_map.hpp"
#include "toolchain/objects/image.hpp"
#include "toolchain/objects/object.hpp"

namespace toolchain {

/// All reasons for which objects cannot be linked. what() has one message per line.
class LinkError : public std::runtime_error {
 public:
  explicit LinkError(std::vector<std::string> messages);
  const std::vector<std::string>& messages() const { return messages_; }

 private:
  std::vector<std::string> messages_;
};

struct Linked {
  Image image;
  std::string map;  ///< The addresses of everything, as text.
};

/// Links the objects in their order; then those of `library` that define symbols which are still undefined, and the
/// objects that these need. Throws LinkError.
Linked link(std::vector<Object> objects, const std::vector<Object>& library, const MemoryMap& map);

/// Files may be objects or libraries. Throws LinkError, CoffError.
Linked link_files(const std::vector<std::filesystem::path>& files, const MemoryMap& map);

/// The word with a relocation applied. `symbol_now` and `place_now` are the final addresses of the symbol and of the
/// word, `symbol_then` and `place_then` the addresses in the object. Returns the exact value that the field must have
/// in `target`; none if the field is too small.
struct Relocated {
  Word word = 0;
  bool fits = true;
  std::int64_t value = 0;  ///< Value of the field: an address or a distance.
};
Relocated relocate(Word word, const Relocation& relocation, Word symbol_then, Word symbol_now, Word place_then,
                   Word place_now, bool symbol_is_section, bool is_address);

}  // namespace toolchain
