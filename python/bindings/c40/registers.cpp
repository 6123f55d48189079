// Peripheral registers.
#include <pybind11/stl.h>

#include "c40/peripherals/register_map.hpp"
#include "python/bindings/c40/c40.hpp"

void bind_registers(py::module_& m) {
  m.def("register_page", &c40::register_page, "The register tables of docs/peripherals.md.");
}
