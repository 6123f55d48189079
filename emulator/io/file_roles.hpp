#pragma once
// The files that a command reads and writes: no output may be an input or another output.
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace io {

class SameFile : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What io::read_input has read before an output is named is an input, whether or not it was named here. Two names mean
/// the same file if they lead to one file of the file system, links followed. Files that do not exist yet are the same
/// if their names are. Devices, pipes and sockets may be named more than once.
class FileRoles {
 public:
  /// \param role the user's name for the file, for the message: "--report", "the source"
  FileRoles& reads(std::string role, const std::string& path);
  /// Every file in the folder and below it is an input.
  FileRoles& reads_folder(std::string role, const std::string& path);
  /// \throws SameFile if the command reads the file, or writes it already
  FileRoles& writes(std::string role, const std::string& path);

 private:
  struct Entry {
    std::string role, path, identity;
    bool written;
  };
  void add(std::string role, const std::string& path, bool written);

  std::vector<Entry> entries_;
  std::vector<std::pair<std::string, std::string>> folders_;
};

}  // namespace io
