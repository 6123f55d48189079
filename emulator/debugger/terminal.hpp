#pragma once
/// The source of commands: a terminal with history and completion, or standard input.
#include "debugger/console.hpp"

namespace debugger {

/// Reads commands until `quit` or the end of input. Ctrl-C ends the running command, not the debugger.
void converse(Console& console, machine::debug::Debugger& debugger);

/// During its lifetime Ctrl-C ends the debugger's running command.
class CtrlCInterrupts {
 public:
  explicit CtrlCInterrupts(machine::debug::Debugger& debugger);
  ~CtrlCInterrupts();
  CtrlCInterrupts(const CtrlCInterrupts&) = delete;
  CtrlCInterrupts& operator=(const CtrlCInterrupts&) = delete;
};

}  // namespace debugger
