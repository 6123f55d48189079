#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <csignal>

#include "io/file_roles.hpp"
#include "io/nearest.hpp"
#include "io/output_file.hpp"
#include "io/print.hpp"
#include "python/bindings/bindings.hpp"
#include "python/bindings/interpreter/errors.hpp"

namespace {

volatile std::sig_atomic_t signals_came = 0;

void signal_came(int number) {
  if (signals_came == 0) {
    signals_came = 1;
    PyErr_SetInterruptEx(number);
  } else {
    std::signal(number, SIG_DFL);
    std::raise(number);
  }
}

// Python itself looks at its signals one after the other, now and then: the second could be lost with the first.
void second_signal_ends(const std::vector<int>& numbers) {
  struct ::sigaction action{};
  action.sa_handler = signal_came;
  ::sigfillset(&action.sa_mask);
  signals_came = 0;
  for (const int number : numbers) ::sigaction(number, &action, nullptr);
}

}  // namespace

void bind_io(py::module_& core) {
  auto m = core.def_submodule("io", "Files that appear whole or not at all.");
  python::register_error<io::CannotOpen>(m, "CannotOpen", PyExc_OSError);
  python::register_error<io::SameFile>(m, "SameFile", PyExc_ValueError);
  m.def(
      "write",
      [](const std::filesystem::path& path, const py::bytes& content) {
        io::OutputFile file(path.string());
        const auto text = static_cast<std::string_view>(content);
        file.stream().write(text.data(), static_cast<std::streamsize>(text.size()));
        try {
          file.commit();
        } catch (const std::runtime_error& error) {
          py::set_error(PyExc_OSError, error.what());
          throw py::error_already_set();
        }
      },
      py::arg("path"), py::arg("content"), "Writes the file whole or not at all. Raises OSError.");
  m.def(
      "printable", [](const py::bytes& text) { return io::printable(static_cast<std::string_view>(text)); },
      py::arg("text"), "What a terminal shows and does not obey: control characters become \\xNN.");
  m.def(
      "did_you_mean",
      [](const std::string& given, const std::vector<std::string>& known) { return io::did_you_mean(given, known); },
      py::arg("given"), py::arg("known"), "'; did you mean \"waits\"?', or nothing if no known word is near.");
  m.def("second_signal_ends", &second_signal_ends, py::arg("numbers"),
        "The first of these signals is for Python's handler; the second ends the process, whatever Python does.");
  py::class_<io::FileRoles>(m, "FileRoles",
                            "Which files are read and which are written: no output may be an input or another output.")
      .def(py::init<>())
      .def(
          "reads",
          [](io::FileRoles& roles, std::string role, const std::filesystem::path& path) {
            roles.reads(std::move(role), path.string());
          },
          py::arg("role"), py::arg("path"))
      .def(
          "writes",
          [](io::FileRoles& roles, std::string role, const std::filesystem::path& path) {
            roles.writes(std::move(role), path.string());
          },
          py::arg("role"), py::arg("path"), "Raises SameFile, a ValueError.");
}
