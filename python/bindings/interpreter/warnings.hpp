#pragma once
// What a user of Python should know, as a UserWarning.
#include <pybind11/pybind11.h>

#include <string>

#include "io/print.hpp"
#include "machine/boards/board_file.hpp"

namespace python {

/// Where Python counts the callers of a function from 1: the first that is not in the package.
inline Py_ssize_t caller_of_the_package() {
  namespace py = pybind11;
  Py_ssize_t level = 1;
  for (py::object frame = py::module_::import("sys").attr("_getframe")(); !frame.is_none();
       frame = frame.attr("f_back"), ++level) {
    const auto module = py::str(frame.attr("f_globals").attr("get")("__name__", "")).cast<std::string>();
    if (module != "cmrc" && !module.starts_with("cmrc.")) break;
  }
  return level;
}

/// \throws error_already_set if the user has made warnings errors
inline void warn(const std::string& text) {
  if (PyErr_WarnEx(PyExc_UserWarning, io::printable(text).c_str(), caller_of_the_package()) < 0)
    throw pybind11::error_already_set();
}

inline void warn_of(const machine::BoardDescription& board) {
  for (const std::string& warning : board.warnings) warn(warning);
}

/// machine::read_board, with its warnings.
inline machine::BoardDescription read_board(const std::string& name) {
  machine::BoardDescription board = machine::read_board(name);
  warn_of(board);
  return board;
}

}  // namespace python
