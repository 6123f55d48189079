#pragma once
// A run of the dock that an editor may attach to.
#include <optional>

#include "cli/options.hpp"
#include "cmrc/run/simulation.hpp"
#include "debugger/dap_server.hpp"

namespace cli {

class Attach {
 public:
  /// Listens, if that is asked for, and says where. \throws InputError for a port that is taken
  explicit Attach(const RunOptions& options);

  /// Before the run: waits for an editor, if that is asked for. False: the editor ended the run.
  bool begin(cmrc::Simulation& simulation);
  /// Between two slices: an editor has come, and the run has to stop for it.
  bool wanted() const { return listener_ && listener_->has_client(); }
  /// Serves it until it goes. False: it ended the run.
  bool serve(cmrc::Simulation& simulation);

 private:
  std::optional<debugger::dap::Listener> listener_;
  bool waits_;
};

}  // namespace cli
