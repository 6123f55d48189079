#include "io/input_file.hpp"

#include <algorithm>
#include <fstream>
#include <mutex>
#include <system_error>

namespace io {

namespace {

std::mutex noting;
std::set<std::filesystem::path> noted;

}  // namespace

std::set<std::filesystem::path> inputs_read() {
  const std::lock_guard lock(noting);
  return noted;
}

Input read_input(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return {{}, "is a directory"};
  std::ifstream in(path, std::ios::binary);
  if (!in) return {{}, "cannot be read"};
  constexpr std::size_t at_once = std::size_t{1} << 16;
  std::string text;
  std::size_t size = 0;
  while (in && size <= largest_input) {
    text.resize(std::max(text.size(), size + at_once));
    in.read(text.data() + size, at_once);
    size += static_cast<std::size_t>(in.gcount());
  }
  if (in.bad()) return {{}, "cannot be read"};
  if (size > largest_input) return {{}, fmt::format("is larger than {} MiB", largest_input >> 20)};
  text.resize(size);
  const std::lock_guard lock(noting);
  noted.insert(path);
  return {std::move(text), {}};
}

}  // namespace io
