// emulator limits. Studies of many runs are commands of the Python package, cmrc, which is installed beside this
// program. In a wheel the program is inside the package; the variable CMRC_SCRIPTS then says where the commands are.
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <vector>

#include "cli/arguments/options.hpp"

namespace cli {

int cmrc_command(const CmrcCommandOptions& options) {
  std::error_code unknown;
  const char* scripts = std::getenv("CMRC_SCRIPTS");
  const std::filesystem::path folder = scripts != nullptr
                                           ? std::filesystem::path(scripts)
                                           : std::filesystem::read_symlink("/proc/self/exe", unknown).parent_path();
  const std::string program = (folder / "cmrc").string();
  std::vector<std::string> words = {program, options.name};
  words.insert(words.end(), options.arguments.begin(), options.arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  ::execv(program.c_str(), pointers.data());
  throw InputError(
      fmt::format("{0}: is a command of the Python package, and {1} cannot be started: {2}. If cmrc is installed "
                  "elsewhere: cmrc {0}. To install it: pip install . in the folder of the sources, or make build",
                  options.name, program, std::strerror(errno)));
}

}  // namespace cli
