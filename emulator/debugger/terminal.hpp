#pragma once
/// The source of commands: a terminal with history and completion, or standard input.
#include "debugger/console.hpp"

namespace debugger {

/// Reads commands until `quit` or the end of input. Ctrl-C ends the running command, or drops the line that is being
/// written, not the debugger.
void converse(Console& console, machine::debug::Debugger& debugger);

}  // namespace debugger
