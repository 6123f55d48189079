#include "python/bindings/bindings.hpp"

void bind_toolchain(py::module_&) {}
