#include "toolchain/assembler.hpp"

#include "toolchain/program.hpp"
#include "toolchain/reader.hpp"

namespace toolchain {
namespace {

Image finish(Program& program, std::vector<Diagnostic> diagnostics) {
  Image image = program.finish(diagnostics);
  if (!diagnostics.empty()) throw AssemblyError(std::move(diagnostics));
  return image;
}

}  // namespace

Image assemble_file(const std::filesystem::path& path, const Options& options) {
  Program program(options);
  std::vector<Diagnostic> diagnostics;
  Reader reader(program, options, diagnostics);
  try {
    reader.read_file(path);
  } catch (const LineError& error) {
    throw AssemblyError({Diagnostic{path.string(), 0, 1, false, error.message, "", {}}});
  }
  return finish(program, std::move(diagnostics));
}

Image assemble_text(std::string_view text, const std::string& name, const Options& options) {
  Program program(options);
  std::vector<Diagnostic> diagnostics;
  Reader(program, options, diagnostics).read_text(text, name, {});
  return finish(program, std::move(diagnostics));
}

}  // namespace toolchain
