#pragma once
// An output file that appears whole or not at all.
#include <filesystem>
#include <memory>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "io/signals.hpp"

namespace io {

/// An output cannot be opened: the caller's name cannot be written.
class CannotOpen : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Writes a file beside its target and renames it on commit. Until commit, and without it, the target stays as it was.
///
/// If the file system allows it, the file beside the target has no name until commit, so that nothing is left even if
/// the program is killed. A link stays a link: the file to which the link leads is replaced. An existing file's mode is
/// kept. A target that is not a regular file (a terminal, a pipe, a device) is written directly. So is a file into
/// which the shell has led standard output or error: what is printed there would be lost with the old file.
class OutputFile {
 public:
  /// \throws CannotOpen if the target cannot be written, before anything else happens
  explicit OutputFile(const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  std::ostream& stream() { return stream_; }
  /// \throws std::runtime_error if the disk is full, a reader has closed the pipe, or the file cannot replace its
  /// target
  void commit();
  /// The same; an error is noted in lost_outputs(), so that the work continues and the other outputs are written.
  void commit_or_note();

 private:
  class Buffer;

  void open_beside();
  void give_name();
  void replace_target();

  std::filesystem::path given_;          // the caller's name
  std::filesystem::path target_;         // the file to which links lead
  std::optional<TemporaryName> beside_;  // the new file beside the target; none while this file has no name
  bool direct_ = false;
  std::unique_ptr<Buffer> buffer_;
  std::ostream stream_;
};

/// An output is lost, for this reason; the others are written.
void note_lost(std::string what);
/// The errors of commit_or_note, and what note_lost was given, so far. The program prints them at its end, and fails.
const std::vector<std::string>& lost_outputs();

}  // namespace io
