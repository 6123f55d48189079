// emulator debug: a program, a network or the dock, controlled by commands.
#include "cli/debug/debug_target.hpp"
#include "debugger/console.hpp"
#include "debugger/terminal.hpp"
#include "io/print.hpp"
#include "machine/debug/debugger.hpp"

namespace cli {

int debug(const DebugOptions& options) {
  const DebugTarget target = debug_target(options);
  machine::debug::Debugger debugger(*target.debuggee);
  debugger::Console console(debugger, debugger::print_line);
  const bool by_scripts = !options.scripts.empty(), attended = !by_scripts && debugger::attended();
  if (attended) io::print("emulator debug: help lists the commands, quit ends.\n");
  if (!by_scripts) console.show_stop();
  if (attended) {
    debugger::converse(console, debugger, options.commands);
    return console.status();
  }
  for (const std::string& command : options.commands)
    if (!console.unattended(command, "-e")) return console.status();
  try {
    for (const std::string& script : options.scripts) console.script(script);
    if (!by_scripts) debugger::read_commands(console);
  } catch (const machine::debug::DebugError& error) {
    throw InputError(error.what());
  }
  return console.status();
}

}  // namespace cli
