#pragma once
/// Where commands come from: a terminal with history and completion, or standard input.
#include "debugger/console.hpp"

namespace debugger {

/// Reads commands until `quit` or the end of input. Ctrl-C ends the command under way, not the debugger.
void converse(Console& console, machine::debug::Debugger& debugger);

/// Ctrl-C ends the debugger's command under way while this lives.
class CtrlCInterrupts {
 public:
  explicit CtrlCInterrupts(machine::debug::Debugger& debugger);
  ~CtrlCInterrupts();
  CtrlCInterrupts(const CtrlCInterrupts&) = delete;
  CtrlCInterrupts& operator=(const CtrlCInterrupts&) = delete;
};

}  // namespace debugger
