#pragma once
// Each room's binding adds its classes and functions to a submodule of cmrc._core, named as the room.
#include <pybind11/pybind11.h>

namespace py = pybind11;

void bind_io(py::module_& core);
void bind_trace(py::module_& core);
void bind_report(py::module_& core);
void bind_isa(py::module_& core);
void bind_c40(py::module_& core);
void bind_toolchain(py::module_& core);
void bind_programs(py::module_& toolchain);
void bind_plant(py::module_& core);
void bind_network(py::module_& core);
void bind_debug(py::module_& core);
void bind_cmrc(py::module_& core);
void bind_why_late(py::module_& core);
