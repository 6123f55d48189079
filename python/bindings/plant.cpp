#include "python/bindings/bindings.hpp"

void bind_plant(py::module_&) {}
