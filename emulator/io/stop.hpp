#pragma once
// How whatever takes long learns that it is to stop: it asks at slices, and the front end of its thread answers.
#include <functional>
#include <stdexcept>

namespace io {

/// Thrown by what has nothing to show when it is stopped half-way.
class Stopped : public std::runtime_error {
 public:
  Stopped() : std::runtime_error("stopped before it was done") {}
};

/// Whether this thread's work is to stop. False where nobody is there to say so: a library has no signals of its own.
bool stop_asked();
/// \throws Stopped when it is
void stop_if_asked();

/// While this lives, stop_asked() of this thread asks `asker`; at its end whom it asked before.
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

/// In a child process: what asked in the parent is not there.
void forget_asker();

}  // namespace io
