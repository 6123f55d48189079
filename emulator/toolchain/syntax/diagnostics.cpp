#include "toolchain/syntax/diagnostics.hpp"

#include <fmt/format.h>

namespace toolchain {
namespace {

std::string join(const std::vector<Diagnostic>& diagnostics) {
  std::string out;
  for (const Diagnostic& diagnostic : diagnostics) {
    if (!out.empty()) out += '\n';
    out += diagnostic.format();
  }
  return out;
}

/// Blanks up to the caret; tabs are kept so that the caret is under its column on any terminal.
std::string indentation(std::string_view text, std::size_t width) {
  std::string out;
  for (std::size_t i = 0; i < width; ++i) out += i < text.size() && text[i] == '\t' ? '\t' : ' ';
  return out;
}

}  // namespace

SourceLine of_option(std::string_view option, std::string text) {
  return {std::make_shared<const std::string>(option), 0, std::move(text), nullptr};
}

std::string Diagnostic::format() const {
  const char* const kind = warning ? "warning" : "error";
  if (line == 0) return fmt::format("{} {}: {}: {}", file, text, kind, message);
  std::string out = fmt::format("{}:{}:{}: {}: {}\n  {}\n  {}^", file, line, column, kind, message, text,
                                indentation(text, static_cast<std::size_t>(column - 1)));
  for (const std::string& note : notes) out += "\n  " + note;
  return out;
}

Diagnostic make_diagnostic(const SourceLine& line, std::size_t offset, std::string message, bool warning) {
  Diagnostic diagnostic{*line.file, line.number, static_cast<int>(offset) + 1, warning, std::move(message),
                        line.text,  {}};
  for (const SourceLine* from = line.expanded_from.get(); from != nullptr; from = from->expanded_from.get())
    diagnostic.notes.push_back(fmt::format("expanded from {}:{}: {}", *from->file, from->number, from->text));
  return diagnostic;
}

AssemblyError::AssemblyError(std::vector<Diagnostic> diagnostics)
    : std::runtime_error(join(diagnostics)), diagnostics_(std::move(diagnostics)) {}

}  // namespace toolchain
