#include "python/bindings/bindings.hpp"

void bind_isa(py::module_&) {}
