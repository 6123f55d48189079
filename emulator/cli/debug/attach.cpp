#include "cli/debug/attach.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <system_error>
#include <utility>

#include "cmrc/run/dock_debuggee.hpp"
#include "io/print.hpp"
#include "machine/debug/debugger.hpp"

namespace cli {

Attach::Attach(const RunOptions& options) : waits_(options.debug_wait) {
  if (waits_ && !options.debug_port) throw InputError("--debug-wait: needs --debug PORT");
  if (!options.debug_port) return;
  const std::array<std::pair<const char*, bool>, 4> collects{{{"--profile", options.profile.has_value()},
                                                              {"--perfetto", options.perfetto.has_value()},
                                                              {"--page", options.page.has_value()},
                                                              {"--trace", options.trace.has_value()}}};
  for (const auto& [option, given] : collects)
    if (given)
      throw InputError(fmt::format(
          "--debug: it can go back, and what {} has collected cannot be taken back; give one of the two", option));
  try {
    listener_.emplace(*options.debug_port);
  } catch (const std::system_error& error) {
    throw InputError(fmt::format("--debug: {}", error.what()));
  }
  io::print(stderr, "emulator: an editor may attach to port {} of this machine\n", listener_->port());
}

bool Attach::begin(cmrc::Simulation& simulation) { return !waits_ || serve(simulation); }

bool Attach::serve(cmrc::Simulation& simulation) {
  const int client = listener_->accept();
  if (client < 0) return false;  // a signal
  cmrc::DockDebuggee debuggee(simulation);
  machine::debug::Debugger debugger(debuggee);
  const debugger::dap::Ended ended = debugger::dap::serve(client, client, debugger);
  close(client);
  if (!ended.broken.empty()) io::print(stderr, "emulator: the editor's messages: {}\n", ended.broken);
  return !ended.terminate;
}

}  // namespace cli
