#pragma once
// The assembler: TI's C3x/C4x syntax (docs/assembler.md), driven by the instruction table.
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "toolchain/objects/object.hpp"
#include "toolchain/syntax/diagnostics.hpp"
#include "toolchain/syntax/dialect.hpp"

namespace toolchain {

struct Options {
  std::vector<std::filesystem::path> include_dirs;  ///< Searched after the directory of the including file.
  std::map<std::string, Word> symbols;              ///< Predefined constants.
  /// Addresses of sections. Others follow in this order: .text, .data, further loaded ones, .bss, further reserved
  /// ones; each after the one before it.
  std::map<std::string, Address> sections = {{".text", 0x300000}};
  /// The symbol at which the program starts. If empty: _start, _c_int00, c_int00, start, START or the first word of
  /// .text.
  std::string entry;
  /// How to read what TI's assembler and GNU as read differently, in files that do not say it by `.dialect`. None: as
  /// TI's does, but a file with GCC's mark as GNU as does.
  std::optional<Dialect> dialect;
  /// In an object, symbols that are neither defined nor declared are left to other objects; so they are with GNU as.
  bool undefined_external = false;
  isa::Cpu cpu = isa::Cpu::c40;  ///< Whose instructions and registers the source names.
};

/// Throws AssemblyError with every error of the source; a file that cannot be read is one of them.
Image assemble_file(const std::filesystem::path& path, const Options& options = {});

/// `name` stands for the text in diagnostics.
Image assemble_text(std::string_view text, const std::string& name = "<text>", const Options& options = {});

/// A relocatable object (`Options::sections` and `entry` have no meaning for it), and its lines and warnings. Symbols
/// that are declared by .global or .ref and not defined are left to the linker. Throws AssemblyError.
struct AssembledObject {
  Object object;
  Image listed;  ///< Every section begins at 0.
};
AssembledObject assemble_object_file(const std::filesystem::path& path, const Options& options = {});
AssembledObject assemble_object_text(std::string_view text, const std::string& name = "<text>",
                                     const Options& options = {});

}  // namespace toolchain
