#pragma once
// Ctrl-C in long calls: KeyboardInterrupt, or whatever else the program's handler raises, and nothing else.
#include <chrono>
#include <optional>
#include <type_traits>
#include <utility>

#include "io/stop.hpp"
#include "python/bindings/bindings.hpp"
#include "python/bindings/float_environment.hpp"

/// While it lives, Python's signals are looked at whenever this thread's work asks io::stop_asked(). Python does so in
/// its main thread only.
class CtrlC {
 public:
  CtrlC()
      : asker_([this] {
          const auto now = Clock::now();
          if (raised_ || now - looked_ < often_enough) return raised_.has_value();
          looked_ = now;
          const py::gil_scoped_acquire gil;
          if (PyErr_CheckSignals() != 0) raised_.emplace();
          return raised_.has_value();
        }) {}
  /// With the GIL. \throws what the handler has raised
  void raise() {
    if (!raised_) return;
    throw py::error_already_set(*std::exchange(raised_, std::nullopt));
  }

 private:
  using Clock = std::chrono::steady_clock;
  // Looking for signals needs the GIL; other threads may have it for a while.
  static constexpr std::chrono::milliseconds often_enough{50};

  Clock::time_point looked_ = Clock::now();
  std::optional<py::error_already_set> raised_;
  io::StopAsker asker_;
};

/// Does `work` without changing the GIL, and calculates as a new process does. Then raises the exception that Ctrl-C
/// has raised during the work.
template <class Work>
auto interruptible(Work work) {
  const UsualFloats floats;
  CtrlC ctrl_c;
  try {
    if constexpr (std::is_void_v<decltype(work())>) {
      work();
      ctrl_c.raise();
    } else {
      auto result = work();
      ctrl_c.raise();
      return result;
    }
  } catch (const io::Stopped&) {
    ctrl_c.raise();
    throw;
  }
}

/// The same without the GIL.
template <class Work>
auto interruptible_without_gil(Work work) {
  return interruptible([&] {
    const py::gil_scoped_release released;
    return work();
  });
}
