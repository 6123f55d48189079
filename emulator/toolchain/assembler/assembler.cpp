#include "toolchain/assembler/assembler.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "toolchain/assembler/program.hpp"
#include "toolchain/assembler/reader.hpp"

namespace toolchain {
namespace {

/// Into the order of the source: files in the order in which they first occur, then lines.
void sort(std::vector<Diagnostic>& diagnostics) {
  std::vector<std::string> files;
  const auto rank = [&](const Diagnostic& d) {
    const auto place = std::find(files.begin(), files.end(), d.file) - files.begin();
    if (place == std::ssize(files)) files.push_back(d.file);
    return std::tuple(place, d.line, d.column);
  };
  std::vector<std::pair<std::tuple<std::ptrdiff_t, int, int>, Diagnostic>> ranked;
  for (Diagnostic& d : diagnostics) ranked.emplace_back(rank(d), std::move(d));
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 0; i < ranked.size(); ++i) diagnostics[i] = std::move(ranked[i].second);
}

/// Throws the diagnostics, if there are any.
void conclude(std::vector<Diagnostic> diagnostics) {
  sort(diagnostics);
  if (diagnostics.size() > most_errors) {
    diagnostics.erase(diagnostics.begin() + most_errors + 1, diagnostics.end());
    diagnostics.back().message +=
        fmt::format(" (there may be more errors; the assembler gives up after {})", most_errors);
  }
  if (!diagnostics.empty()) throw AssemblyError(std::move(diagnostics));
}

void read_file(Program& program, const std::filesystem::path& path, const Options& options,
               std::vector<Diagnostic>& diagnostics) {
  Reader reader(program, options, diagnostics);
  try {
    reader.read_file(path);
  } catch (const LineError& error) {
    throw AssemblyError({Diagnostic{path.string(), 0, 1, false, error.message, "", {}}});
  }
}

Image finish(Program& program, std::vector<Diagnostic> diagnostics) {
  Image image = program.finish(diagnostics);
  conclude(std::move(diagnostics));
  return image;
}

AssembledObject finish_object(Program& program, const std::string& name, std::vector<Diagnostic> diagnostics) {
  AssembledObject out;
  out.object = program.finish_object(out.listed, diagnostics);
  out.object.name = name;
  conclude(std::move(diagnostics));
  return out;
}

}  // namespace

Image assemble_file(const std::filesystem::path& path, const Options& options) {
  Program program(options);
  std::vector<Diagnostic> diagnostics;
  read_file(program, path, options, diagnostics);
  return finish(program, std::move(diagnostics));
}

Image assemble_text(std::string_view text, const std::string& name, const Options& options) {
  Program program(options);
  std::vector<Diagnostic> diagnostics;
  Reader(program, options, diagnostics).read_text(text, name, {});
  return finish(program, std::move(diagnostics));
}

AssembledObject assemble_object_file(const std::filesystem::path& path, const Options& options) {
  Program program(options);
  std::vector<Diagnostic> diagnostics;
  read_file(program, path, options, diagnostics);
  return finish_object(program, path.string(), std::move(diagnostics));
}

AssembledObject assemble_object_text(std::string_view text, const std::string& name, const Options& options) {
  Program program(options);
  std::vector<Diagnostic> diagnostics;
  Reader(program, options, diagnostics).read_text(text, name, {});
  return finish_object(program, name, std::move(diagnostics));
}

}  // namespace toolchain
