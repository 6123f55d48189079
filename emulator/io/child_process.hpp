#pragma once
// A piece of work in a process of its own. A thread would not do: ODE has one random number generator per process, so a
// run has the same results as alone only in a process of its own.
#include <functional>
#include <string>

namespace io {

/// One piece of work in a child process. The child process ends with this object or with its parent.
class ChildProcess {
 public:
  /// The child ignores the signals that end its parent, because a terminal sends signals to both.
  /// \throws std::runtime_error if the system cannot start a process
  explicit ChildProcess(const std::function<std::string()>& work);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Whether the child has sent something, or has ended, within this time.
  bool speaks(int milliseconds) const;
  /// Waits for the answer. \throws std::runtime_error with the text of the child's exception, or if the child has died;
  /// io::Stopped, after which wait() may be called again
  std::string wait();

 private:
  /// Reads a part of the answer; false if the answer has ended.
  bool read();

  int process_ = 0, pipe_ = -1;
  std::string answer_;
};

}  // namespace io
