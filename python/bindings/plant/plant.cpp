#include "python/bindings/plant/plant.hpp"

void bind_plant(py::module_& core) {
  auto m = core.def_submodule("plant", "Crane, AGVs, containers, drives and sensors. Times are integer picoseconds.");
  bind_plant_parameters(m);
  bind_plant_surroundings(m);
  bind_plant_places(m);
  bind_plant_layout(m);
  bind_plant_motion(m);
  bind_plant_alone(m);
  bind_plant_records(m);
  bind_plant_dock(m);
  bind_plant_linkage(m);
}
