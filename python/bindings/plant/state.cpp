// A dock's snapshot for Python: copied, and as bytes for builds of the same layout alone.
#include "plant/dock/state.hpp"
#include "python/bindings/interpreter/state.hpp"
#include "python/bindings/plant/plant.hpp"

using namespace plant;

void bind_plant_state(py::module_& m) {
  py::class_<DockState, std::shared_ptr<DockState>>(m, "DockState", "A dock's complete state at a latch; opaque.")
      .def("__copy__", [](const DockState& s) { return s; })
      .def("__deepcopy__", [](const DockState& s, const py::dict&) { return s; })
      .def(py::pickle(&value_bytes<DockState>, &value_of_bytes<DockState>));
}
