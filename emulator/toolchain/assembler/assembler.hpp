#pragma once
// The assembler: TI's C3x/C4x syntax (docs/assembler.md), driven by the instruction table.
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "toolchain/objects/object.hpp"
#include "toolchain/objects/section_places.hpp"
#include "toolchain/syntax/diagnostics.hpp"
#include "toolchain/syntax/dialect.hpp"

namespace toolchain {

struct Options {
  std::vector<std::filesystem::path> include_dirs;  ///< Searched after the directory of the including file.
  std::map<std::string, Word> symbols;              ///< Predefined constants.
  /// Addresses of sections. The other sections are put where these leave room: .text, .data, further loaded ones, .bss,
  /// further reserved ones.
  std::map<std::string, Address> sections = {{".text", usual_address}};
  /// The symbol at which the program starts. If empty: _start, _c_int00, c_int00, start, START or the first word of
  /// .text.
  std::string entry;
  /// The dialect of files that do not name it with `.dialect`: how to read what TI's assembler and GNU as read
  /// differently. None: as TI's assembler does; but a file with GCC's mark as GNU as does.
  std::optional<Dialect> dialect;
  /// In an object, symbols that are neither defined nor declared are left to other objects, as GNU as does.
  bool undefined_external = false;
  isa::Cpu cpu = isa::Cpu::c40;  ///< The processor whose instructions and registers the source names.
};

/// Throws AssemblyError with every error of the source; a file that cannot be read is one of them.
Image assemble_file(const std::filesystem::path& path, const Options& options = {});

/// `name` is the name of the text in diagnostics.
Image assemble_text(std::string_view text, const std::string& name = "<text>", const Options& options = {});

/// A relocatable object (without `Options::sections` and `entry`), and its lines and warnings. Symbols that .global or
/// .ref declares and the source does not define are left to the linker. Throws AssemblyError.
struct AssembledObject {
  Object object;
  Image listed;  ///< Every section begins at 0.
};
AssembledObject assemble_object_file(const std::filesystem::path& path, const Options& options = {});
AssembledObject assemble_object_text(std::string_view text, const std::string& name = "<text>",
                                     const Options& options = {});

}  // namespace toolchain
