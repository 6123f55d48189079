#pragma once
// Parts of the emulator that tests drive one by one: each file adds a submodule to cmrc_test. No wheel has them.
#include <pybind11/pybind11.h>

namespace py = pybind11;

void bind_bus_model(py::module_& test);
void bind_ledger(py::module_& test);
void bind_machine(py::module_& test);
void bind_plant(py::module_& test);
void bind_program_forms(py::module_& test);
void bind_report(py::module_& test);
void bind_rows(py::module_& test);
void bind_run_setup(py::module_& test);
void bind_scheduling(py::module_& test);

// Parts of a submodule, in files of their own.
void bind_bus_settings(py::module_& bus_model);
void bind_bus_statistics(py::module_& bus_model);
void bind_machine_settings(py::module_& machine);
