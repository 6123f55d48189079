// emulator config: the configuration that a run would have.
#include <fmt/format.h>

#include "cli/options.hpp"
#include "cli/settings.hpp"
#include "cmrc/config.hpp"

namespace cli {

int print_config(const ConfigOptions& options) {
  if (options.processes) fmt::print("{}", cmrc::built_in_processes_text());
  else fmt::print("{}", to_toml(build_config(options.run)));
  return success;
}

}  // namespace cli
