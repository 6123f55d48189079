#pragma once
// Independent pieces of work in processes of their own, several at a time. Processes, not threads: ODE keeps its random
// numbers once per process, so only processes give each run the results that it has alone.
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace cmrc {

/// One piece of work in a child process, which ends with this object or with its parent.
class ChildProcess {
 public:
  /// Deaf to signals that end its parent: at a terminal they come to both. \throws std::runtime_error when there is no
  /// process to be had
  explicit ChildProcess(const std::function<std::string()>& work);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Where its answer comes from, for poll().
  int pipe() const { return pipe_; }
  /// Reads some of the answer: false when it has ended.
  bool read();
  /// Whether it says something, or has ended, within so long.
  bool speaks(int milliseconds) const;
  /// Waits for the answer. \throws std::runtime_error with what its exception said, or when it has died; io::Stopped,
  /// and may be called again
  std::string wait();

 private:
  int process_ = 0, pipe_ = -1;
  std::string answer_;
};

/// Runs work(0) to work(count - 1), at most `at_once` at a time, each in a child process, and returns what they return,
/// in order; nothing for those that had not ended when io::stop_asked().
///
/// \param done is told of each result as it comes, in any order
/// \throws std::runtime_error with what a child's exception said, or when one has died; the others are ended first
std::vector<std::optional<std::string>> in_processes(std::size_t count, unsigned at_once,
                                                     const std::function<std::string(std::size_t)>& work,
                                                     const std::function<void(std::size_t, const std::string&)>& done);

/// As many as this machine has processors.
unsigned processors();

}  // namespace cmrc
