#include "io/file_roles.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <filesystem>
#include <system_error>

namespace io {
namespace {

/// What identifies a file; empty for devices, pipes and sockets, which may be named twice.
std::string identity(const std::string& path) {
  struct ::stat found{};
  if (::stat(path.c_str(), &found) == 0)
    return S_ISREG(found.st_mode) ? fmt::format("{}:{}", found.st_dev, found.st_ino) : "";
  std::error_code error;
  const auto whole = std::filesystem::weakly_canonical(std::filesystem::absolute(path, error), error);
  return error ? path : whole.string();
}

}  // namespace

void FileRoles::add(std::string role, const std::string& path, bool written) {
  if (path.empty()) return;
  Entry entry{std::move(role), path, identity(path), written};
  if (entry.identity.empty()) return;
  for (const Entry& other : entries_) {
    if (other.identity != entry.identity || (!entry.written && !other.written)) continue;
    const Entry& output = entry.written ? entry : other;
    const Entry& first = entry.written ? other : entry;
    throw SameFile(fmt::format("{}: {} is the same file as {} ({}); another name is expected", output.role, output.path,
                               first.role, first.path));
  }
  entries_.push_back(std::move(entry));
}

FileRoles& FileRoles::reads(std::string role, const std::string& path) {
  add(std::move(role), path, false);
  return *this;
}

FileRoles& FileRoles::writes(std::string role, const std::string& path) {
  add(std::move(role), path, true);
  return *this;
}

}  // namespace io
