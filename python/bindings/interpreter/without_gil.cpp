#include "python/bindings/interpreter/without_gil.hpp"

#include <atomic>
#include <chrono>
#include <thread>

namespace {

std::atomic<bool> ends = false;
int threads = 0;  // without the GIL, or on their way back to it; whoever changes it has the GIL

/// A thread whose callback waits for something else cannot be stopped: the end does not wait for it for long.
void stop_and_await() {
  using Clock = std::chrono::steady_clock;
  ends = true;
  for (const auto last = Clock::now() + std::chrono::seconds{5}; threads > 0 && Clock::now() < last;) {
    const py::gil_scoped_release released;
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
}

}  // namespace

bool in_main_thread() {
  const py::object main_thread = py::module_::import("threading").attr("main_thread")();
  return main_thread.attr("ident").cast<unsigned long>() == PyThread_get_thread_ident();
}

bool python_ends() { return ends; }

void end_thread() {
  PyErr_SetNone(PyExc_SystemExit);
  throw py::error_already_set();
}

WithoutGil::WithoutGil() {
  if (python_ends()) end_thread();
  ++threads;
  released_.emplace();
}

WithoutGil::~WithoutGil() {
  released_.reset();
  --threads;
}

void await_threads_at_the_end_of_python() {
  py::module_::import("atexit").attr("register")(py::cpp_function(stop_and_await));
  // A child has only the thread that has forked.
  py::module_::import("os").attr("register_at_fork")(py::arg("after_in_child") = py::cpp_function([] { threads = 0; }));
}
