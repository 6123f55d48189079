#pragma once
/// The source of commands: a terminal with history and completion, or standard input.
#include <string>
#include <vector>

#include "debugger/console.hpp"

namespace debugger {

/// Standard input is a terminal: somebody sees the answers.
bool attended();
/// Prints a line of an answer.
void print_line(const std::string& text);

/// Executes the commands of standard input, up to `quit`, its end, or one that fails.
/// \throws machine::debug::DebugError for input that cannot be read
void read_commands(Console& console);
/// At a terminal: executes these commands, then those that somebody types, up to `quit` or the end of input. Ctrl-C
/// ends the running command, or drops the line that is being written, not the debugger.
void converse(Console& console, machine::debug::Debugger& debugger, const std::vector<std::string>& first);

}  // namespace debugger
