// emulator without a command: simulates the dock.
#include <stdexcept>

#include "cli/options.hpp"
#include "cli/settings.hpp"

namespace cli {

int run(const RunOptions& options) {
  build_config(options);
  throw std::runtime_error("the simulation is not linked into this build");
}

}  // namespace cli
