#pragma once
// How long work can be stopped: it asks at its slices, and the front end of its thread answers.
#include <functional>
#include <stdexcept>

namespace io {

/// Thrown by work that has no result if it is stopped half-way.
class Stopped : public std::runtime_error {
 public:
  Stopped() : std::runtime_error("stopped before it was done") {}
};

/// Whether this thread's work has to stop. False if no front end answers: a library has no signals of its own.
bool stop_asked();
/// \throws Stopped if the work has to stop
void stop_if_asked();

/// During its lifetime, stop_asked() of this thread asks `asker`; afterwards the one before.
class StopAsker {
 public:
  explicit StopAsker(std::function<bool()> asker);
  ~StopAsker();
  StopAsker(const StopAsker&) = delete;
  StopAsker& operator=(const StopAsker&) = delete;

 private:
  std::function<bool()> asker_;
  const std::function<bool()>* before_;
};

/// For a child process: the parent's asker does not exist here.
void forget_asker();

}  // namespace io
