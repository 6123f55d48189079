#pragma once
// Ctrl-C in long calls: KeyboardInterrupt, or whatever else the program's handler raises, and nothing else.
#include <chrono>
#include <functional>
#include <optional>
#include <type_traits>
#include <utility>

#include "io/stop.hpp"
#include "python/bindings/bindings.hpp"
#include "python/bindings/interpreter/float_environment.hpp"
#include "python/bindings/interpreter/without_gil.hpp"

/// During its lifetime, Python's signals are looked at whenever this thread's work asks io::stop_asked(): in Python's
/// main thread, the only one that gets them. In any other thread the end of Python stops the work.
class CtrlC {
 public:
  CtrlC()
      : asker_(in_main_thread_ ? std::function<bool()>([this] { return signal_raised(); })
                               : std::function<bool()>(python_ends)) {}
  /// With the GIL. \throws what the handler has raised, or SystemExit
  void raise() {
    if (raised_) throw py::error_already_set(*std::exchange(raised_, std::nullopt));
    if (!in_main_thread_ && python_ends()) end_thread();
  }

 private:
  using Clock = std::chrono::steady_clock;
  // Looking for signals needs the GIL; other threads may have it for a while.
  static constexpr std::chrono::milliseconds often_enough{50};

  bool signal_raised() {
    const auto now = Clock::now();
    if (raised_ || now - looked_ < often_enough) return raised_.has_value();
    looked_ = now;
    const py::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) raised_.emplace();
    return raised_.has_value();
  }

  const bool in_main_thread_ = in_main_thread();
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
    const WithoutGil released;
    return work();
  });
}
