#pragma once
// SIGINT, SIGTERM and SIGHUP in a program. The library installs no handler.
#include <csignal>
#include <string>

#include "io/stop.hpp"

namespace io {

/// From now on a signal ends the program at once with status 128 + its number, and temporary files are gone. One that
/// is ignored at the start (nohup) stays ignored.
void take_signals();

/// While it lives, the first signal is noted only: stop_asked() is true, the work ends at its next slice and writes
/// what it has. The second ends the program at once.
class StopBySignal {
 public:
  StopBySignal();
  ~StopBySignal();
  StopBySignal(const StopBySignal&) = delete;
  StopBySignal& operator=(const StopBySignal&) = delete;

  /// 128 + the signal that was noted; `otherwise` if there was none
  int status(int otherwise) const;

 private:
  StopAsker asker_;
};

/// The three wait while this lives.
class SignalsHeld {
 public:
  SignalsHeld();
  ~SignalsHeld();
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;

 private:
  ::sigset_t before_;
};

/// In a child process: its parent hears the signals of the terminal and ends it.
void ignore_signals();

/// A file that is gone when a signal ends the program. Made and destroyed with the signals held.
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

/// Of this process. Safe in a signal handler.
void remove_temporaries();

}  // namespace io
