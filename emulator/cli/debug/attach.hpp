#pragma once
// A run of the dock to which an editor may attach.
#include <optional>

#include "cli/arguments/options.hpp"
#include "cmrc/run/simulation.hpp"
#include "debugger/dap_server.hpp"

namespace cli {

class Attach {
 public:
  /// Listens if the option is given, and prints the port. \throws InputError for a port that is in use
  explicit Attach(const RunOptions& options);

  /// Before the run: waits for an editor if --debug-wait is given. False: the editor ended the run.
  bool begin(cmrc::Simulation& simulation);
  /// Between two slices: an editor has connected, and the run has to stop for it.
  bool wanted() const { return listener_ && listener_->has_client(); }
  /// Serves the editor until it disconnects. False: the editor ended the run.
  bool serve(cmrc::Simulation& simulation);

 private:
  std::optional<debugger::dap::Listener> listener_;
  bool waits_;
};

}  // namespace cli
