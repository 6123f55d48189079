#include "debugger/terminal.hpp"

#include <editline/readline.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <clocale>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <utility>

#include "debugger/console_words.hpp"
#include "io/input_file.hpp"
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

/// The instant of a long command, on a line of its own that the next text replaces.
class Running {
 public:
  void begin() { begun_ = last_ = std::chrono::steady_clock::now(); }
  void at(machine::Time time) {
    const auto now = std::chrono::steady_clock::now();
    if (now - begun_ < patience || now - last_ < period) return;
    last_ = now;
    shown_ = true;
    std::fprintf(stdout, "\r%.6f s ", static_cast<double>(time.count()) * 1e-12);
    std::fflush(stdout);
  }
  void clear() {
    if (!std::exchange(shown_, false)) return;
    std::fprintf(stdout, "\r%*s\r", 24, "");
    std::fflush(stdout);
  }

 private:
  static constexpr std::chrono::milliseconds patience{1000}, period{200};
  std::chrono::steady_clock::time_point begun_, last_;
  bool shown_ = false;
};
Running running;

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

/// A line of standard input, or the beginning of one that is too long. A command is executed when its line is there,
/// and its answer is written before the next line is read, so that whoever writes the commands can wait for the
/// answers. False: nothing is left.
bool next_line(std::string& line) {
  std::fflush(stdout);
  line.clear();
  int c = std::getc(stdin);
  const bool any = c != EOF;
  for (; c != EOF && c != '\n' && line.size() <= io::largest_input; c = std::getc(stdin)) line += static_cast<char>(c);
  return any;
}

}  // namespace

bool attended() { return isatty(STDIN_FILENO) != 0; }

void print_line(const std::string& text) {
  running.clear();
  io::print("{}\n", text);
}

void read_commands(Console& console) {
  int number = 0;
  for (std::string line; next_line(line);) {
    const std::string place = fmt::format("standard input:{}", ++number);
    if (line.size() > io::largest_input)
      throw machine::debug::DebugError(
          fmt::format("{}: a line longer than {} MiB; commands are expected", place, io::largest_input >> 20));
    if (number == 1) line.erase(0, mark_of_utf8(line));
    if (!console.unattended(line, place)) return;
  }
  if (std::ferror(stdin) != 0)
    throw machine::debug::DebugError("standard input: cannot be read; commands are expected");
}

void converse(Console& console, machine::debug::Debugger& debugger, const std::vector<std::string>& first) {
  const CtrlCInterrupts ctrl_c(debugger);
  if (isatty(STDOUT_FILENO) != 0)
    debugger.progress = [](machine::Time at, machine::Time, machine::Time) { running.at(at); };
  const auto command = [&](const std::string& line) {
    running.begin();
    const bool continues = console.command(line);
    running.clear();
    return continues;
  };
  for (const std::string& line : first) {
    if (!command(line)) return;
    if (console.paused()) break;
  }
  // Of what is typed, libedit drops what the locale does not have.
  if (std::setlocale(LC_CTYPE, "") == nullptr || MB_CUR_MAX == 1) std::setlocale(LC_CTYPE, "C.UTF-8");
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
    if (!command(line.get())) return;
  }
}

}  // namespace debugger
