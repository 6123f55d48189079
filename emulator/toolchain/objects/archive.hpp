#pragma once
// Libraries of objects: the "ar" format, which TI's and GNU's archivers share.
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace toolchain {

struct ArchiveMember {
  std::string name;
  std::span<const std::byte> bytes;  ///< Part of the archive's bytes.
};

bool is_archive(std::span<const std::byte> bytes);

/// The members, without symbol tables and name tables. Throws CoffError with the archive's `name`.
std::vector<ArchiveMember> archive_members(std::span<const std::byte> bytes, const std::string& name);

}  // namespace toolchain
