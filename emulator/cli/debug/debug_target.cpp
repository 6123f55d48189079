#include "cli/debug/debug_target.hpp"

#include <fmt/format.h>

#include <string>

#include "cli/arguments/network_arguments.hpp"
#include "cli/arguments/settings.hpp"
#include "cli/exec/board_front.hpp"
#include "cli/exec/exec_memory.hpp"
#include "cli/exec/exec_report.hpp"
#include "cli/exec/exec_run.hpp"
#include "cli/output_files/snapshots.hpp"
#include "cmrc/run/dock_debuggee.hpp"
#include "machine/debug/network_debuggee.hpp"

namespace cli {
namespace {

bool is_network(const ExecOptions& exec) { return !exec.programs.empty() || exec.network || exec.boot; }

/// The words of --until ADDRESS==WORD, which end the run of one chip.
machine::debug::NetworkDebuggee::EndWords end_words(ExecOptions exec, const machine::Network& network) {
  std::erase_if(exec.until, [](const std::string& text) { return text.find("==") == std::string::npos; });
  if (exec.until.empty()) return {};
  auto words = parse_until(exec, network.program(0)).words;
  for (const auto& [address, word] : words) read_dump(network.chip(0), address, 1, "--until");
  return words;
}

DebugTarget network_of(const DebugOptions& options) {
  const RunOptions& run = options.run;
  if (run.dsps || run.config || run.preset || run.duration_s || run.seed || !run.settings.empty() || run.resume)
    throw InputError(
        "debug: --dsps, --config, --preset, --duration, --seed, --set and --snapshot are for the dock, and a program "
        "or network is given");
  if (const auto reader = reader_of_standard_input(options.exec))
    throw InputError(fmt::format("debug: {}: a file is expected; the debugger reads standard input itself", *reader));
  if (options.exec.console_record) throw InputError("debug: --console-record: only exec writes this file");
  require_boot_for_roms(options.exec);
  if (options.exec.network && options.exec.boot)
    throw InputError("--boot: of a --network file, boot = true of a [[chip]] says it");
  DebugTarget target;
  target.network = std::make_unique<machine::Network>(described(options.exec));
  for (const std::string& text : options.exec.actions) target.network->schedule(action_of(text, *target.network));
  target.debuggee =
      std::make_unique<machine::debug::NetworkDebuggee>(*target.network, end_words(options.exec, *target.network));
  return target;
}

DebugTarget dock_of(const DebugOptions& options) {
  const ExecOptions& exec = options.exec;
  if (exec.console_input || !exec.device_inputs.empty() || !exec.device_scripts.empty())
    throw InputError(
        "debug: --console-input, --device-input and --device-script are for programs and networks; give a PROGRAM or "
        "--network");
  require_boot_for_roms(exec);
  if (!exec.links.empty() || !exec.nets.empty() || !exec.actions.empty() || exec.entry || exec.load_at ||
      exec.memory_max || exec.boards.size() > 1 || !exec.loads.empty() || !exec.pokes.empty() || !exec.until.empty())
    throw InputError(
        "debug: --link, --net, --action, --entry, --load-at, --load, --poke, --until and --memory-max are for programs "
        "and networks; give a PROGRAM or --network");
  RunOptions run = options.run;
  if (!exec.boards.empty()) run.board = exec.boards.front();
  run.topology = exec.topology;
  std::optional<cmrc::Snapshot> from;
  if (run.resume) from = read_snapshot(*run.resume);
  DebugTarget target;
  target.simulation = std::make_unique<cmrc::Simulation>(from ? build_config(run, from->configuration(), *run.resume)
                                                              : build_config(run));
  try {
    if (from) target.simulation->restore(*from);
  } catch (const cmrc::SnapshotError& error) {
    throw InputError(fmt::format("{}: {}", *run.resume, error.what()));
  }
  target.debuggee = std::make_unique<cmrc::DockDebuggee>(*target.simulation);
  return target;
}

}  // namespace

DebugTarget debug_target(const DebugOptions& options) {
  return is_network(options.exec) ? network_of(options) : dock_of(options);
}

}  // namespace cli
