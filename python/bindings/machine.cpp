#include "python/bindings/bindings.hpp"

void bind_machine(py::module_&) {}
