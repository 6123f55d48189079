// emulator debug: a program, a network or the dock, controlled by commands.
#include <unistd.h>

#include "cli/debug/debug_target.hpp"
#include "debugger/console.hpp"
#include "debugger/terminal.hpp"
#include "io/print.hpp"
#include "machine/debug/debugger.hpp"

namespace cli {

int debug(const DebugOptions& options) {
  const DebugTarget target = debug_target(options);
  machine::debug::Debugger debugger(*target.debuggee);
  debugger::Console console(debugger, [](const std::string& text) { io::print("{}\n", text); });
  const bool by_hand = options.scripts.empty();
  if (by_hand && isatty(STDIN_FILENO) != 0) io::print("emulator debug: help lists the commands, quit ends.\n");
  if (by_hand) console.show_stop();
  for (const std::string& command : options.commands)
    if (!console.command(command)) return console.status();
  try {
    for (const std::string& script : options.scripts) console.script(script);
  } catch (const machine::debug::DebugError& error) {
    throw InputError(error.what());
  }
  if (options.scripts.empty()) debugger::converse(console, debugger);
  return console.status();
}

}  // namespace cli
