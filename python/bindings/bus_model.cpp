#include "python/bindings/bindings.hpp"

void bind_bus_model(py::module_&) {}
