#pragma once
// Objects and libraries to one program with settled addresses (docs/assembler.md, "The linker").
#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "toolchain/linker/memory_map.hpp"
#include "toolchain/objects/image.hpp"
#include "toolchain/objects/object.hpp"

namespace toolchain {

/// Everything that keeps objects from being linked. what() is one message per line.
class LinkError : public std::runtime_error {
 public:
  explicit LinkError(std::vector<std::string> messages);
  const std::vector<std::string>& messages() const { return messages_; }

 private:
  std::vector<std::string> messages_;
};

struct Linked {
  Image image;
  std::string map;  ///< What went where, as text.
};

/// The objects in their order; then, from `library`, those that define what is still undefined, and what these want in
/// turn. Throws LinkError.
Linked link(std::vector<Object> objects, std::vector<Object> library, const MemoryMap& map);

/// Files may be objects or libraries. Throws LinkError, CoffError.
Linked link_files(const std::vector<std::filesystem::path>& files, const MemoryMap& map);

/// The word with a relocation applied: `symbol_now` and `place_now` are the final addresses of the symbol and of the
/// word, `symbol_then` and `place_then` those that the object was written for. Gives the exact value that the field
/// should stand for in `target`; none if the field cannot hold it.
struct Relocated {
  Word word = 0;
  bool fits = true;
  std::int64_t value = 0;  ///< Of the field: an address or a distance.
};
Relocated relocate(Word word, const Relocation& relocation, Word symbol_then, Word symbol_now, Word place_then,
                   Word place_now, bool symbol_is_section);

}  // namespace toolchain
