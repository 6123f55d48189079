#include "debugger/terminal.hpp"

#include <editline/readline.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <memory>

#include "io/print.hpp"

namespace debugger {
namespace {

std::atomic<machine::debug::Debugger*> interruptible{nullptr};
std::atomic<bool> pressed{false};  // Ctrl-C
struct sigaction before;

extern "C" void interrupt_debugger(int) {
  pressed = true;
  if (machine::debug::Debugger* debugger = interruptible) debugger->interrupt();
}

// libedit needs a plain function.
const Console* completing = nullptr;

char* next_completion(const char* /*text*/, int state) {
  static std::vector<std::string> words;
  static std::size_t next = 0;
  if (state == 0) {
    words = completing->completions(std::string_view(rl_line_buffer, static_cast<std::size_t>(rl_point)));
    next = 0;
  }
  return next < words.size() ? strdup(words[next++].c_str()) : nullptr;
}

char** complete(const char* text, int, int) {
  rl_attempted_completion_over = 1;  // file names are not completed
  return rl_completion_matches(text, next_completion);
}

struct Freed {
  void operator()(char* text) const { std::free(text); }
};

/// During its lifetime Ctrl-C ends the debugger's running command.
class CtrlCInterrupts {
 public:
  explicit CtrlCInterrupts(machine::debug::Debugger& debugger) {
    interruptible = &debugger;
    struct sigaction action{};
    action.sa_handler = interrupt_debugger;
    sigaction(SIGINT, &action, &before);
  }
  ~CtrlCInterrupts() {
    sigaction(SIGINT, &before, nullptr);
    interruptible = nullptr;
  }
  CtrlCInterrupts(const CtrlCInterrupts&) = delete;
  CtrlCInterrupts& operator=(const CtrlCInterrupts&) = delete;
};

}  // namespace

void converse(Console& console, machine::debug::Debugger& debugger) {
  const CtrlCInterrupts ctrl_c(debugger);
  if (isatty(STDIN_FILENO) == 0) {
    for (std::string line; std::getline(std::cin, line);)
      if (!console.command(line)) return;
    return;
  }
  completing = &console;
  rl_attempted_completion_function = complete;
  rl_completer_word_break_characters = const_cast<char*>(" \t([+-*/&|^=<>!~,");  // NOLINT: libedit's declaration
  using_history();
  for (;;) {
    pressed = false;
    const std::unique_ptr<char, Freed> line(readline(console.prompt().c_str()));
    if (!line && pressed) {
      io::print("\n");
      continue;
    }
    if (!line) return;
    if (line.get()[0] != '\0') add_history(line.get());
    if (!console.command(line.get())) return;
  }
}

}  // namespace debugger
