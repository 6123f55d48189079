#include "io/file_roles.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <filesystem>
#include <system_error>

#include "io/input_file.hpp"

namespace io {
namespace {

/// The path without links, also where the last one leads to a file that is not there yet.
std::filesystem::path whole(std::filesystem::path path) {
  std::error_code error;
  constexpr int deepest = 40;  // as the kernel follows them
  for (int depth = 0; depth < deepest && std::filesystem::is_symlink(path, error); ++depth)
    path = path.parent_path() / std::filesystem::read_symlink(path, error);
  const auto found = std::filesystem::weakly_canonical(std::filesystem::absolute(path, error), error);
  return error ? path : found;
}

/// What identifies a file; empty for devices, pipes and sockets, which may be named twice.
std::string identity(const std::string& path) {
  struct ::stat found{};
  if (::stat(path.c_str(), &found) == 0)
    return S_ISREG(found.st_mode) ? fmt::format("{}:{}", found.st_dev, found.st_ino) : "";
  return whole(path).string();
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
  if (written) {
    const auto refuse = [&](const std::string& why) {
      throw SameFile(fmt::format("{}: {} {}; another name is expected", entry.role, entry.path, why));
    };
    for (const std::filesystem::path& input : inputs_read())
      if (identity(input.string()) == entry.identity)
        refuse(fmt::format("is the same file as an input ({})", input.string()));
    for (const auto& [what, folder] : folders_) {
      const auto below = whole(path).lexically_relative(whole(folder));
      if (!below.empty() && *below.begin() != "..") refuse(fmt::format("is in the folder of {} ({})", what, folder));
    }
  }
  entries_.push_back(std::move(entry));
}

FileRoles& FileRoles::reads(std::string role, const std::string& path) {
  add(std::move(role), path, false);
  return *this;
}

FileRoles& FileRoles::reads_folder(std::string role, const std::string& path) {
  if (!path.empty()) folders_.emplace_back(std::move(role), path);
  return *this;
}

FileRoles& FileRoles::writes(std::string role, const std::string& path) {
  add(std::move(role), path, true);
  return *this;
}

}  // namespace io
