#pragma once
// Errors and warnings of the assembler, always with their place.
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace toolchain {

/// One line of source as it was assembled, after macro substitution.
struct SourceLine {
  std::shared_ptr<const std::string> file;
  int number = 0;  ///< Counted from 1; 0 for an option in place of a line.
  std::string text;
  std::shared_ptr<const SourceLine> expanded_from;  ///< The macro call or loop that produced this line.
};
using SourceLinePtr = std::shared_ptr<const SourceLine>;

/// In place of a line, what an option says: `--entry`, `main`.
SourceLine of_option(std::string_view option, std::string text);

struct Diagnostic {
  std::string file;
  int line = 0;    ///< Counted from 1; 0: `file` is the name of an option, `text` its value.
  int column = 0;  ///< Counted from 1.
  bool warning = false;
  std::string message;
  std::string text;                ///< The offending line.
  std::vector<std::string> notes;  ///< The macro calls that led to the line.

  /// "file:line:column: error: message", the line, a caret under the column, the notes; "--option value: error:
  /// message".
  std::string format() const;
};

Diagnostic make_diagnostic(const SourceLine& line, std::size_t offset, std::string message, bool warning = false);

/// After so many errors an assembly is given up.
inline constexpr std::size_t most_errors = 1000;

/// Every error of a source text at once. what() is their formatted text.
class AssemblyError : public std::runtime_error {
 public:
  explicit AssemblyError(std::vector<Diagnostic> diagnostics);
  const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

 private:
  std::vector<Diagnostic> diagnostics_;
};

/// Thrown within the assembler: an error at an offset of the present line.
struct LineError {
  std::size_t offset = 0;
  std::string message;
  int half = 0;  ///< 1: in the line of a parallel instruction's second half.
};

}  // namespace toolchain
