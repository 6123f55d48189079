// A dock's snapshot for Python: copied, and as bytes for builds of the same layout alone.
#include "plant/state.hpp"
#include "python/bindings/plant.hpp"
#include "python/bindings/state.hpp"

using namespace plant;

namespace {

struct Whole {
  DockState& state;
  void list_state(state::Visitor& list) { list("state", state); }
};

py::bytes bytes_of(const DockState& state) {
  return state_bytes(Whole{const_cast<DockState&>(state)});  // NOLINT: saving only reads
}

DockState state_of(const py::bytes& bytes) {
  DockState state;
  Whole whole{state};
  load_state(whole, bytes);
  return state;
}

}  // namespace

void bind_plant_state(py::module_& m) {
  py::class_<DockState, std::shared_ptr<DockState>>(m, "DockState", "A dock's complete state at a latch; opaque.")
      .def("__copy__", [](const DockState& s) { return s; })
      .def("__deepcopy__", [](const DockState& s, const py::dict&) { return s; })
      .def(py::pickle(&bytes_of, &state_of));
}
