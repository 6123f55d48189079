#pragma once
// Which files a command reads and which it writes: no output may be an input or another output.
#include <stdexcept>
#include <string>
#include <vector>

namespace io {

class SameFile : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Files are the same when they are one file of the file system, whatever their names, links followed; what does not
/// exist yet, when its name is the same. Devices, pipes and sockets may be named as often as one likes.
class FileRoles {
 public:
  /// \param role how the user named it, for the message: "--report", "the source"
  FileRoles& reads(std::string role, const std::string& path);
  /// \throws SameFile when the file is read, or written already
  FileRoles& writes(std::string role, const std::string& path);

 private:
  struct Entry {
    std::string role, path, identity;
    bool written;
  };
  void add(std::string role, const std::string& path, bool written);

  std::vector<Entry> entries_;
};

}  // namespace io
