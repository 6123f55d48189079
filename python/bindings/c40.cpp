#include "python/bindings/bindings.hpp"

void bind_c40(py::module_&) {}
