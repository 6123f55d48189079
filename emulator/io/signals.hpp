#pragma once
// SIGINT, SIGTERM and SIGHUP in a program. The library installs no handler.
#include <csignal>
#include <string>

#include "io/stop.hpp"

namespace io {

/// From now on a signal ends the program at once with status 128 + its number, and temporary files are removed. A
/// signal that is ignored at the start (nohup) stays ignored. A file that reaches `ulimit -f`, or a pipe that nobody
/// reads any more, ends no program.
void take_signals();

/// During its lifetime the first signal is only noted: stop_asked() is true, the work ends at its next slice and writes
/// its results. The second signal ends the program at once.
class StopBySignal {
 public:
  StopBySignal();
  ~StopBySignal();
  StopBySignal(const StopBySignal&) = delete;
  StopBySignal& operator=(const StopBySignal&) = delete;

  /// 128 + the noted signal's number; `otherwise` if there was no signal
  int status(int otherwise) const;

 private:
  StopAsker asker_;
};

/// Holds back these three signals during its lifetime.
class SignalsHeld {
 public:
  SignalsHeld();
  ~SignalsHeld();
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;

 private:
  ::sigset_t before_;
};

/// For a child process: its parent gets the terminal's signals and ends the child.
void ignore_signals();

/// The name of a file that is removed if a signal ends the program. Construct and destroy it with the signals held
/// back.
class TemporaryName {
 public:
  explicit TemporaryName(std::string path);
  ~TemporaryName();
  TemporaryName(const TemporaryName&) = delete;
  TemporaryName& operator=(const TemporaryName&) = delete;

  const std::string path;

 private:
  friend void remove_temporaries();
  TemporaryName* next_;
};

/// Removes the temporary files of this process. Safe in a signal handler.
void remove_temporaries();

}  // namespace io
