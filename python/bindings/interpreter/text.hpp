#pragma once
// Text between Python and C++. Every source of the module includes this first (python/CMakeLists.txt), since pybind11
// must not have made its own caster for std::string before.
//
// The name of a file may hold any byte. Python has a byte that is no UTF-8 as a lone surrogate (PEP 383); pybind11
// would refuse such a text in its own words, and could not give one back.
#include <pybind11/cast.h>

#include <string>

namespace pybind11::detail {

template <>
struct type_caster<std::string> {
  PYBIND11_TYPE_CASTER(std::string, const_name("str"));

  bool load(handle source, bool) {
    if (PyUnicode_Check(source.ptr())) {
      auto bytes = reinterpret_steal<object>(PyUnicode_AsEncodedString(source.ptr(), "utf-8", "surrogateescape"));
      if (!bytes) {  // a surrogate that stands for no byte
        PyErr_Clear();
        bytes = reinterpret_steal<object>(PyUnicode_AsEncodedString(source.ptr(), "utf-8", "backslashreplace"));
      }
      if (!bytes) throw error_already_set();
      value.assign(PyBytes_AS_STRING(bytes.ptr()), static_cast<std::size_t>(PyBytes_GET_SIZE(bytes.ptr())));
    } else if (PyBytes_Check(source.ptr())) {
      value.assign(PyBytes_AS_STRING(source.ptr()), static_cast<std::size_t>(PyBytes_GET_SIZE(source.ptr())));
    } else {
      return false;
    }
    return true;
  }

  static handle cast(const std::string& text, return_value_policy, handle) {
    PyObject* made = PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "surrogateescape");
    if (made == nullptr) throw error_already_set();
    return made;
  }
};

}  // namespace pybind11::detail

namespace python {

/// For readers: messages, and sources, which may hold any bytes. A byte that is no UTF-8 becomes `\xNN`.
inline pybind11::str shown(const std::string& text) {
  return pybind11::reinterpret_steal<pybind11::str>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "backslashreplace"));
}

}  // namespace python
