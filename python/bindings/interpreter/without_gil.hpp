#pragma once
// Work without the GIL, and the end of Python. A thread that wants the GIL back after this end is killed inside C++,
// and that takes the process with it.
#include <optional>

#include "python/bindings/bindings.hpp"

/// With the GIL: whether this is the thread that gets Python's signals.
bool in_main_thread();

/// Python has begun to end: work in other threads than the main one has to stop.
bool python_ends();

/// Python ends such a thread without a word. With the GIL. \throws SystemExit
[[noreturn]] void end_thread();

/// During its lifetime this thread does not have the GIL. Python's end waits for all such threads.
class WithoutGil {
 public:
  /// With the GIL. \throws SystemExit if Python ends
  WithoutGil();
  ~WithoutGil();
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;

 private:
  std::optional<py::gil_scoped_release> released_;
};

/// Has Python call what stops and awaits these threads.
void await_threads_at_the_end_of_python();
