#pragma once
// A Python function that gets the progress of a run and may stop the run.
#include <fmt/format.h>

#include <exception>
#include <functional>
#include <string>

#include "cmrc/run/simulation.hpp"
#include "python/bindings/bindings.hpp"

/// What is called during a run without the GIL. What the Python function raises, also the Ctrl-C that Python
/// has heard in it, ends the run and is raised by `raise`.
class OnProgress {
 public:
  /// \throws py::type_error
  explicit OnProgress(py::object function) : function_(std::move(function)) {
    if (!function_.is_none() && PyCallable_Check(function_.ptr()) == 0)
      throw py::type_error("on_progress: " + std::string(py::str(py::type::of(function_))) +
                           " cannot be called; a function of (simulated_s, duration_s) or None is expected");
  }
  OnProgress(const OnProgress&) = delete;
  OnProgress& operator=(const OnProgress&) = delete;

  /// For Simulation::run; empty where Python gave None.
  std::function<bool(const cmrc::Progress&)> call() {
    if (function_.is_none()) return {};
    return [this](const cmrc::Progress& progress) {
      const py::gil_scoped_acquire gil;
      try {
        return continues(function_(report::seconds(progress.simulated), report::seconds(progress.duration)));
      } catch (const std::exception&) {
        raised_ = std::current_exception();
        return false;
      }
    };
  }

  /// With the GIL. \throws the exception that the function has raised
  void raise() const {
    if (raised_) std::rethrow_exception(raised_);
  }

 private:
  static bool continues(const py::object& returned) {
    if (returned.is_none()) return true;
    try {
      return returned.cast<bool>();
    } catch (const py::cast_error&) {
      throw py::type_error(fmt::format("on_progress: it returned {}; True, False or None is expected",
                                       std::string(py::repr(returned)).substr(0, 60)));
    }
  }

  py::object function_;
  std::exception_ptr raised_;
};
