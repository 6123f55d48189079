// Layouts, docks and layout files.
#include <pybind11/native_enum.h>
#include <pybind11/stl.h>

#include "plant/parameters/layout_file.hpp"
#include "python/bindings/interpreter/errors.hpp"
#include "python/bindings/plant/plant.hpp"

using namespace plant;

namespace {

void bind_docks(py::module_& m) {
  {
    using P = Layout;
    py::class_<P>(m, "Layout", "What is where on the dock, m and rad (docs/layout.md).")
        .def(py::init<>()) FIELD(deck) FIELD(rows) FIELD(scan_x0) FIELD(scan_dx) FIELD(containers) FIELD(container_mass)
            FIELD(ship) FIELD(no_go) FIELD(movers) FIELD(spot) FIELD(warehouse) FIELD(warehouse_radius)
                FIELD(warehouse_take) FIELD(slot_spacing) FIELD(legs);
  }
  py::native_enum<Method>(m, "Method", "enum.Enum")
      .value("erk", Method::erk)
      .value("adams", Method::adams)
      .value("bdf", Method::bdf)
      .finalize();
  using P = DockConfig;
  py::class_<P>(m, "DockConfig", "A dock's configuration; default_dock() is the one to begin with.")
      .def(py::init<>()) FIELD(crane) FIELD(landing) FIELD(agv) FIELD(sensors) FIELD(wind) FIELD(ship) FIELD(layout)
          FIELD(collisions) FIELD(rigid) FIELD(agv_count) FIELD(home) FIELD(drive_delay) FIELD(drive_timeout)
              FIELD(method) FIELD(tolerance) FIELD(signal_decimation) FIELD(signal_rows_max);
  m.def("default_dock", &default_dock, py::arg("agv_count") = 1, "the dock of docs/plant.md");
  m.def("gantry_dock", &gantry_dock, py::arg("agv_count") = 1, "the dock with a ship-to-shore gantry");
  python::register_error<LayoutError>(m, "LayoutError", PyExc_ValueError);
  m.def("apply_layout", &apply_layout, py::arg("config"), py::arg("text"), py::arg("name") = "layout",
        "a layout in TOML into a DockConfig");
  m.def("load_layout", &load_layout, py::arg("config"), py::arg("path"), "the same from a file");
}

}  // namespace

void bind_plant_layout(py::module_& m) { bind_docks(m); }
