#pragma once
// A file that appears whole or not at all.
#include <filesystem>
#include <memory>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>

#include "io/signals.hpp"

namespace io {

/// An output cannot be opened: the caller named what cannot be written.
class CannotOpen : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Writes a file beside its target and renames it on commit: until then, and without commit, the target is left as it
/// was.
///
/// The file beside the target has no name until commit where the file system allows that, so that nothing of it is left
/// even when the program is killed. A link stays a link: the file behind it is replaced. The mode of a file that was
/// there is kept. A target that is no regular file (a terminal, a pipe, a device) is written into directly.
class OutputFile {
 public:
  /// \throws CannotOpen when the target cannot be written, before anything else is done
  explicit OutputFile(const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  std::ostream& stream() { return stream_; }
  /// \throws std::runtime_error when the disk is full, a reader has gone, or the file cannot take its place
  void commit();

 private:
  class Buffer;

  void open_beside();
  void give_name();
  void replace_target();

  std::filesystem::path given_;          // as the caller named it
  std::filesystem::path target_;         // the file behind links
  std::optional<TemporaryName> beside_;  // its stand-in; none while that has no name
  bool direct_ = false;
  std::unique_ptr<Buffer> buffer_;
  std::ostream stream_;
};

}  // namespace io
