#pragma once
// A piece of work in a process of its own. A process, not a thread: ODE keeps its random numbers once per process, so
// only in a process a run has the results that it has alone.
#include <functional>
#include <string>

namespace io {

/// One piece of work in a child process, which ends with this object or with its parent.
class ChildProcess {
 public:
  /// The child ignores the signals that end its parent: a terminal sends them to both.
  /// \throws std::runtime_error when the system gives no process
  explicit ChildProcess(const std::function<std::string()>& work);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Whether it says something, or has ended, within so long.
  bool speaks(int milliseconds) const;
  /// Waits for the answer. \throws std::runtime_error with what its exception said, or when it has died; io::Stopped,
  /// and may be called again
  std::string wait();

 private:
  /// Reads some of the answer: false when it has ended.
  bool read();

  int process_ = 0, pipe_ = -1;
  std::string answer_;
};

}  // namespace io
