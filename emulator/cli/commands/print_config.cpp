// emulator config: prints the configuration of a run.

#include "cli/arguments/options.hpp"
#include "cli/arguments/settings.hpp"
#include "cmrc/configuration/config.hpp"
#include "io/print.hpp"

namespace cli {

int print_config(const ConfigOptions& options) {
  if (options.processes)
    io::print("{}", cmrc::built_in_processes_text());
  else
    io::print("{}", to_toml(with_absolute_paths(build_config(options.run))));
  return success;
}

}  // namespace cli
