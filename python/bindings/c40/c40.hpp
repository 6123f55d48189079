#pragma once
// The parts of cmrc._core.c40, in the order in which they are bound.
#include "python/bindings/bindings.hpp"

void bind_link(py::module_& c40);
void bind_registers(py::module_& c40);
void bind_float40(py::module_& c40);
void bind_snapshots(py::module_& core);
