#pragma once
// The parts of cmrc._core.plant, in the order in which they are bound: what a signature names is bound before it.
#include "python/bindings/bindings.hpp"

void bind_plant_parameters(py::module_& plant);
void bind_plant_surroundings(py::module_& plant);
void bind_plant_places(py::module_& plant);
void bind_plant_layout(py::module_& plant);
void bind_plant_motion(py::module_& plant);
void bind_plant_alone(py::module_& plant);
void bind_plant_records(py::module_& plant);
void bind_plant_dock(py::module_& plant);
void bind_plant_state(py::module_& plant);
void bind_plant_linkage(py::module_& plant);
void bind_plant_contact(py::module_& plant);

// Binds a member of P, the type at hand, under its own name.
#define FIELD(name) .def_readwrite(#name, &P::name)
