#pragma once
// Exceptions of the C++ rooms as classes of Python: each derived from cmrc.Error and from the matching built-in class.
#include <pybind11/pybind11.h>

#include "python/bindings/interpreter/text.hpp"

namespace python {

inline pybind11::tuple error_bases(PyObject* builtin) {
  return pybind11::make_tuple(pybind11::module_::import("cmrc.errors").attr("Error"), pybind11::handle(builtin));
}

template <class Exception>
void register_error(pybind11::module_& m, const char* name, PyObject* builtin) {
  // It lives as long as the module, which is never unloaded.
  static const pybind11::handle type = pybind11::exception<Exception>(m, name, error_bases(builtin)).release();
  pybind11::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const Exception& error) {
      PyErr_SetObject(type.ptr(), shown(error.what()).ptr());
    }
  });
}

}  // namespace python
