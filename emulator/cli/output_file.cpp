#include "cli/output_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "cli/options.hpp"

namespace cli {
namespace fs = std::filesystem;

OutputFile::OutputFile(const std::string& path) : target_(path) {
  std::error_code error;
  if (path.empty()) throw InputError("an output file's name is empty");
  if (fs::is_directory(target_, error))
    throw InputError(fmt::format("{}: is a directory; a file's name is expected", path));
  direct_ = fs::exists(target_, error) && !fs::is_regular_file(target_, error);
  if (!direct_) {
    if (fs::is_symlink(target_, error)) target_ = fs::weakly_canonical(target_, error);
    working_ = target_;
    working_ += fmt::format(".{}.part", ::getpid());
  } else {
    working_ = target_;
  }
  errno = 0;
  stream_.open(working_, std::ios::binary | std::ios::trunc);
  if (!stream_) throw InputError(fmt::format("{}: cannot be written: {}", path, std::strerror(errno)));
}

OutputFile::~OutputFile() {
  if (direct_ || working_.empty()) return;
  stream_.close();
  std::error_code ignored;
  fs::remove(working_, ignored);
}

void OutputFile::commit() {
  stream_.close();
  if (stream_.fail())
    throw std::runtime_error(fmt::format("{}: writing failed: {}", target_.string(), std::strerror(errno)));
  if (!direct_) fs::rename(working_, target_);
  working_.clear();
}

}  // namespace cli
