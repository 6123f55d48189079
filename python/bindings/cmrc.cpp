#include "python/bindings/bindings.hpp"

void bind_cmrc(py::module_&) {}
