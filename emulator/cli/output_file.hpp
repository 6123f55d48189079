#pragma once
// A file that appears whole or not at all.
#include <filesystem>
#include <fstream>
#include <string>

namespace cli {

/// Writes beside its target and renames on commit; without commit the target is left as it was. A target that is no
/// regular file (a terminal, a pipe) is written directly.
class OutputFile {
 public:
  /// \throws InputError when the target cannot be written, before anything else is done.
  explicit OutputFile(const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  std::ostream& stream() { return stream_; }
  /// \throws std::runtime_error when the disk is full or the rename fails.
  void commit();
  /// Where the text stands until commit, for writers that want a path.
  const std::filesystem::path& working_path() const { return working_; }

 private:
  std::filesystem::path target_;
  std::filesystem::path working_;
  std::ofstream stream_;
  bool direct_ = false;
};

}  // namespace cli
