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

Input read_input(const std::filesystem::path& path, std::size_t most) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return {{}, "is a directory"};
  std::ifstream in(path, std::ios::binary);
  if (!in) return {{}, "cannot be read"};
  const auto too_large = [&] { return Input{{}, fmt::format("is larger than {} MiB", most >> 20)}; };
  if (std::filesystem::is_regular_file(path, error) && std::filesystem::file_size(path, error) > most && !error)
    return too_large();
  constexpr std::size_t at_once = std::size_t{1} << 16;
  std::string text;
  std::size_t size = 0;
  while (in && size <= most) {
    text.resize(std::max(text.size(), size + at_once));
    in.read(text.data() + size, at_once);
    size += static_cast<std::size_t>(in.gcount());
  }
  if (in.bad()) return {{}, "cannot be read"};
  if (size > most) return too_large();
  text.resize(size);
  const std::lock_guard lock(noting);
  noted.insert(path);
  return {std::move(text), {}};
}

}  // namespace io
