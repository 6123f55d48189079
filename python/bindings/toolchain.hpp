#pragma once
// What the files that bind the toolchain share.
#include <string>

#include "python/bindings/bindings.hpp"

/// Sources may hold any bytes, in comments for instance.
inline py::str as_str(const std::string& text) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "replace"));
}

void bind_programs(py::module_& toolchain);
