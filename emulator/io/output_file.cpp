#include "io/output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <streambuf>
#include <system_error>
#include <utility>

namespace io {
namespace fs = std::filesystem;
namespace {

/// A name beside the target. File systems allow names of 255 bytes, so that of a long target is cut.
std::string beside_name(const fs::path& target, int attempt) {
  constexpr std::size_t kept = 200;
  const std::string name = target.filename().string().substr(0, kept);
  return (target.parent_path() / fmt::format("{}.{}-{}.part", name, ::getpid(), attempt)).string();
}

fs::path folder_of(const fs::path& target) { return target.has_parent_path() ? target.parent_path() : fs::path("."); }

/// The file to which a chain of links leads, whether it exists or not. The chain has an end: stat has followed it.
fs::path behind_links(fs::path path) {
  std::error_code error;
  while (fs::is_symlink(fs::symlink_status(path, error))) {
    const fs::path next = fs::read_symlink(path, error);
    if (error) break;
    path = next.is_absolute() ? next : path.parent_path() / next;
  }
  return path;
}

/// Standard output or error, if the shell has led it into this file. -1: neither.
int stream_into(const struct ::stat& file) {
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO})
    if (struct ::stat other{};
        ::fstat(stream, &other) == 0 && other.st_dev == file.st_dev && other.st_ino == file.st_ino)
      return stream;
  return -1;
}

constexpr ::mode_t everybody = 0666;  // less the umask

std::vector<std::string> lost;

}  // namespace

/// A stream buffer over a descriptor. After a failure errno is kept for the message.
class OutputFile::Buffer : public std::streambuf {
 public:
  explicit Buffer(int descriptor) : descriptor_(descriptor) { setp(bytes_.data(), bytes_.data() + bytes_.size()); }
  ~Buffer() override { close(); }

  int descriptor() const { return descriptor_; }
  int error() const { return error_; }

  /// Writes the buffer to the file.
  bool flush() {
    const char* from = pbase();
    while (from < pptr()) {
      const ::ssize_t count = ::write(descriptor_, from, static_cast<std::size_t>(pptr() - from));
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) {
        error_ = errno;
        break;
      }
      from += count;
    }
    setp(bytes_.data(), bytes_.data() + bytes_.size());
    return error_ == 0;
  }

  /// Makes sure that the file's bytes are on the disk, if the file system supports this.
  bool to_disk() {
    if (::fsync(descriptor_) == 0 || errno == EINVAL || errno == EROFS || errno == ENOTSUP) return true;
    error_ = errno;
    return false;
  }

  bool close() {
    const int descriptor = std::exchange(descriptor_, -1);
    if (descriptor < 0 || ::close(descriptor) == 0) return true;
    error_ = errno;
    return false;
  }

 protected:
  int_type overflow(int_type c) override {
    if (!flush()) return traits_type::eof();
    if (!traits_type::eq_int_type(c, traits_type::eof())) {
      *pptr() = traits_type::to_char_type(c);
      pbump(1);
    }
    return traits_type::not_eof(c);
  }
  int sync() override { return flush() ? 0 : -1; }

 private:
  int descriptor_;
  int error_ = 0;
  std::array<char, 1 << 16> bytes_;
};

OutputFile::OutputFile(const std::string& path) : given_(path), target_(path), stream_(nullptr) {
  const auto fail = [&path](std::string_view why) {
    throw CannotOpen(fmt::format("{}: cannot be written: {}", path, why));
  };
  if (path.empty()) throw CannotOpen("an output file's name is empty");
  struct ::stat found{};
  const bool there = ::stat(path.c_str(), &found) == 0;
  if (!there && errno != ENOENT) fail(std::strerror(errno));
  if (there && S_ISDIR(found.st_mode))
    throw CannotOpen(fmt::format("{}: is a directory; a file's name is expected", path));
  const int stream = there && S_ISREG(found.st_mode) ? stream_into(found) : -1;
  direct_ = there && (!S_ISREG(found.st_mode) || stream >= 0);
  if (direct_) {
    const int descriptor = stream < 0 ? ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY)
                                      : ::fcntl(stream, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    if (descriptor < 0) fail(std::strerror(errno));
    buffer_ = std::make_unique<Buffer>(descriptor);
  } else {
    target_ = behind_links(target_);
    if (there && ::access(target_.c_str(), W_OK) != 0) fail(std::strerror(errno));
    open_beside();
    if (!buffer_) fail(std::strerror(errno));
    if (there) {
      // The mode is always kept, the owner if the system allows it.
      [[maybe_unused]] const int ignored = ::fchown(buffer_->descriptor(), found.st_uid, found.st_gid);
      ::fchmod(buffer_->descriptor(), found.st_mode & 07777);
    }
  }
  stream_.rdbuf(buffer_.get());
}

void OutputFile::open_beside() {
  // A file without a name gets one through /proc; a bare chroot may have no /proc.
  int descriptor = -1;
  if (::access("/proc/self/fd", X_OK) == 0)
    descriptor = ::open(folder_of(target_).c_str(), O_WRONLY | O_TMPFILE | O_CLOEXEC, everybody);
  for (int attempt = 0; descriptor < 0; ++attempt) {
    const SignalsHeld held;
    const std::string name = beside_name(target_, attempt);
    descriptor = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, everybody);
    if (descriptor >= 0)
      beside_.emplace(name);
    else if (errno != EEXIST)
      return;
  }
  buffer_ = std::make_unique<Buffer>(descriptor);
}

OutputFile::~OutputFile() {
  if (!beside_) return;
  const SignalsHeld held;
  ::unlink(beside_->path.c_str());
  beside_.reset();
}

// linkat does not replace a file, so the new file gets a name of its own first.
void OutputFile::give_name() {
  const std::string self = fmt::format("/proc/self/fd/{}", buffer_->descriptor());
  for (int attempt = 0;; ++attempt) {
    const SignalsHeld held;
    const std::string name = beside_name(target_, attempt);
    if (::linkat(AT_FDCWD, self.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0) {
      beside_.emplace(name);
      return;
    }
    if (errno != EEXIST)
      throw std::runtime_error(fmt::format("{}: writing failed: {}", given_.string(), std::strerror(errno)));
  }
}

void OutputFile::replace_target() {
  const SignalsHeld held;
  if (::rename(beside_->path.c_str(), target_.c_str()) != 0)
    throw std::runtime_error(fmt::format("{}: writing failed: {}", given_.string(), std::strerror(errno)));
  beside_.reset();
}

void note_lost(std::string what) { lost.push_back(std::move(what)); }

const std::vector<std::string>& lost_outputs() { return lost; }

void OutputFile::commit_or_note() {
  try {
    commit();
  } catch (const std::runtime_error& error) {
    lost.emplace_back(error.what());
  }
}

void OutputFile::commit() {
  const auto fail = [this](int error) {
    throw std::runtime_error(fmt::format("{}: writing failed: {}", given_.string(), std::strerror(error)));
  };
  stream_.flush();
  if (!buffer_->flush() || stream_.fail()) fail(buffer_->error());
  if (direct_) {
    if (!buffer_->close()) fail(buffer_->error());
    return;
  }
  if (!buffer_->to_disk()) fail(buffer_->error());
  if (!beside_) give_name();
  if (!buffer_->close()) fail(buffer_->error());
  replace_target();
  // Puts the new name on the disk too, if the file system supports this.
  if (const int folder = ::open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); folder >= 0) {
    ::fsync(folder);
    ::close(folder);
  }
}

}  // namespace io
