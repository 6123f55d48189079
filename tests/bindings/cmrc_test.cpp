#include "tests/bindings/bindings.hpp"

PYBIND11_MODULE(cmrc_test, test) {
  test.doc() = "Parts of the emulator that only tests use.";
  py::module_::import("cmrc._core");  // whose classes stand in the signatures: programs, docks
  bind_bus_model(test);
  bind_ledger(test);
  bind_machine(test);
  bind_plant(test);
  bind_program_forms(test);
  bind_report(test);
  bind_rows(test);
  bind_run_setup(test);
  bind_scheduling(test);
}
