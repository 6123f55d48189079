#pragma once
// Exceptions of the C++ rooms as classes of Python: each derived from cmrc.Error and from the matching built-in class.
#include <pybind11/pybind11.h>

namespace python {

inline pybind11::tuple error_bases(PyObject* builtin) {
  return pybind11::make_tuple(pybind11::module_::import("cmrc.errors").attr("Error"), pybind11::handle(builtin));
}

template <class Exception>
void register_error(pybind11::module_& m, const char* name, PyObject* builtin) {
  pybind11::register_exception<Exception>(m, name, error_bases(builtin));
}

}  // namespace python
