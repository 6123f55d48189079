#pragma once
// Files that are read whole: sources, objects, configurations. To read line by line: cli/arguments/text_lines.hpp.
#include <fmt/format.h>

#include <cstddef>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>

namespace io {

/// Bytes of the largest file that is read whole. A device such as /dev/zero has no end; without a limit, reading one
/// would fill all memory.
inline constexpr std::size_t largest_input = std::size_t{64} << 20;

struct Input {
  std::string text;
  std::string problem;  ///< empty, or what follows "FILE: " in a message: "cannot be read"
};

/// \param most the bytes of the largest file that is read
Input read_input(const std::filesystem::path& path, std::size_t most = largest_input);

/// The paths of all files that read_input has read in this process.
std::set<std::filesystem::path> inputs_read();

/// The contents of a file. \param expected what the file should be, for the message
/// \throws Error "FILE: what is wrong; EXPECTED is expected"
template <typename Error>
std::string read_file(const std::filesystem::path& path, std::string_view expected, std::size_t most = largest_input) {
  Input input = read_input(path, most);
  if (!input.problem.empty())
    throw Error(fmt::format("{}: {}; {} is expected", path.string(), input.problem, expected));
  return std::move(input.text);
}

}  // namespace io
