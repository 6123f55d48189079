#pragma once
// What a user of Python should know, as a UserWarning.
#include <pybind11/pybind11.h>

#include <string>

#include "io/print.hpp"
#include "machine/boards/board_file.hpp"

namespace python {

/// \throws error_already_set if the user has made warnings errors
inline void warn(const std::string& text) {
  constexpr Py_ssize_t callers = 2;  // the line that called the package
  if (PyErr_WarnEx(PyExc_UserWarning, io::printable(text).c_str(), callers) < 0) throw pybind11::error_already_set();
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
