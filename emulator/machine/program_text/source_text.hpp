#pragma once
// An instruction as in its source line.
#include <functional>
#include <map>
#include <string>

#include "toolchain/objects/image.hpp"

namespace machine {

class SourceText {
 public:
  enum class Label : bool { kept, dropped };
  SourceText() = default;
  explicit SourceText(const toolchain::Image& image, Label label);

  /// Without comment, with normal blanks, and both lines of a parallel instruction in one. If no line is known,
  /// disassembled; `symbols` then names branch targets.
  std::string operator()(isa::Address address, isa::Word word,
                         const std::function<std::string(isa::Address)>& symbols = {}) const;

 private:
  std::map<isa::Address, std::string> lines_;
};

}  // namespace machine
