// emulator debug: a program, a network or the dock, by commands.
#include <fmt/format.h>
#include <unistd.h>

#include <memory>

#include "cli/network_arguments.hpp"
#include "cli/options.hpp"
#include "cli/settings.hpp"
#include "cli/snapshots.hpp"
#include "cmrc/debuggee.hpp"
#include "cmrc/simulation.hpp"
#include "debugger/console.hpp"
#include "debugger/terminal.hpp"
#include "io/print.hpp"
#include "machine/debug/network_debuggee.hpp"

namespace cli {
namespace {

namespace core = machine::debug;

/// What is debugged, with all that it stands on.
struct Target {
  std::unique_ptr<machine::Network> network;
  std::unique_ptr<cmrc::Simulation> simulation;
  std::unique_ptr<core::Debuggee> debuggee;
};

bool is_network(const ExecOptions& exec) { return !exec.programs.empty() || exec.network; }

Target network_of(const DebugOptions& options) {
  const RunOptions& run = options.run;
  if (run.dsps || run.config || run.preset || run.duration_s || run.seed || !run.settings.empty() || run.resume)
    throw InputError("debug: --dsps, --config, --preset, --duration, --seed, --set and --snapshot are the dock's, and a program or network is given");
  Target target;
  target.network = std::make_unique<machine::Network>(described(options.exec));
  for (const std::string& text : options.exec.actions) target.network->schedule(action_of(text, *target.network));
  target.debuggee = std::make_unique<core::NetworkDebuggee>(*target.network);
  return target;
}

Target dock_of(const DebugOptions& options) {
  const ExecOptions& exec = options.exec;
  if (!exec.links.empty() || !exec.nets.empty() || !exec.actions.empty() || exec.entry || exec.load_at || exec.memory_max || exec.boards.size() > 1)
    throw InputError("debug: --link, --net, --action, --entry, --load-at and --memory-max are of programs and networks; give a PROGRAM or --network");
  RunOptions run = options.run;
  if (!exec.boards.empty()) run.board = exec.boards.front();
  run.topology = exec.topology;
  std::optional<cmrc::Snapshot> from;
  if (run.resume) from = read_snapshot(*run.resume);
  Target target;
  target.simulation = std::make_unique<cmrc::Simulation>(from ? build_config(run, from->configuration(), *run.resume) : build_config(run));
  try {
    if (from) target.simulation->restore(*from);
  } catch (const cmrc::SnapshotError& error) {
    throw InputError(fmt::format("{}: {}", *run.resume, error.what()));
  }
  target.debuggee = std::make_unique<cmrc::DockDebuggee>(*target.simulation);
  return target;
}

}  // namespace

int debug(const DebugOptions& options) {
  const Target target = is_network(options.exec) ? network_of(options) : dock_of(options);
  core::Debugger debugger(*target.debuggee);
  debugger::Console console(debugger, [](const std::string& text) { io::print("{}\n", text); });
  const bool told = options.scripts.empty();
  if (told && isatty(STDIN_FILENO) != 0) io::print("emulator debug: help lists the commands, quit ends.\n");
  if (told) console.show_stop();
  for (const std::string& command : options.commands)
    if (!console.command(command)) return console.status();
  try {
    const debugger::CtrlCInterrupts ctrl_c(debugger);
    for (const std::string& script : options.scripts) console.script(script);
  } catch (const core::DebugError& error) {
    throw InputError(error.what());
  }
  if (options.scripts.empty()) debugger::converse(console, debugger);
  return console.status();
}

}  // namespace cli
