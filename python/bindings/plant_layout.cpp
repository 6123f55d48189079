// Positions of the dock's equipment: layouts, their docks, and layout files.
#include <pybind11/native_enum.h>
#include <pybind11/stl.h>

#include "plant/parameters/check.hpp"
#include "plant/parameters/layout_file.hpp"
#include "plant/scene/scene.hpp"
#include "python/bindings/errors.hpp"
#include "python/bindings/plant.hpp"

using namespace plant;

namespace {

void bind_places(py::module_& m) {
  {
    using P = Pose;
    py::class_<P>(m, "Pose", "m and rad.")
        .def(py::init<double, double, double>(), py::arg("x"), py::arg("y"), py::arg("heading")) FIELD(x) FIELD(y)
            FIELD(heading);
  }
  {
    using P = CranePose;
    py::class_<P>(m, "CranePose", "Gantry s and the middle of the spreader's underside x, y, z, m; its yaw, rad.")
        .def(py::init<double, double, double, double, double>(), py::arg("s"), py::arg("x"), py::arg("y"), py::arg("z"),
             py::arg("yaw")) FIELD(s) FIELD(x) FIELD(y) FIELD(z) FIELD(yaw);
  }
  {
    using P = Box;
    py::class_<P>(m, "Box", "A box in the world, m.")
        .def(py::init<double, double, double, double, double, double>(), py::arg("x_min"), py::arg("x_max"),
             py::arg("y_min"), py::arg("y_max"), py::arg("z_min"), py::arg("z_max")) FIELD(x_min) FIELD(x_max)
            FIELD(y_min) FIELD(y_max) FIELD(z_min) FIELD(z_max);
  }
  {
    using P = ContainerPlace;
    py::class_<P>(m, "ContainerPlace", "Centre of the underside, m; yaw, rad; gross mass, kg.")
        .def(py::init<double, double, double, double, double>(), py::arg("x"), py::arg("y"), py::arg("z"),
             py::arg("yaw"), py::arg("mass")) FIELD(x) FIELD(y) FIELD(z) FIELD(yaw) FIELD(mass);
  }
  using P = LaneSegment;
  py::class_<P>(m, "LaneSegment",
                "A line or arc of lane driven forward: from x, y (m) and heading (rad), length m, curvature 1/m (left "
                "positive), speed m/s.")
      .def(py::init<double, double, double, double, double, double>(), py::arg("x"), py::arg("y"), py::arg("heading"),
           py::arg("length"), py::arg("curvature"), py::arg("speed")) FIELD(x) FIELD(y) FIELD(heading) FIELD(length)
          FIELD(curvature) FIELD(speed);
}

void bind_movers(py::module_& m) {
  {
    using P = Waypoint;
    py::class_<P>(m, "Waypoint", "Where a mover is, m, at a time, s.")
        .def(py::init<double, double, double>(), py::arg("time"), py::arg("x"), py::arg("y")) FIELD(time) FIELD(x)
            FIELD(y);
  }
  using P = Mover;
  py::class_<P>(m, "Mover", "An upright cylinder that follows its waypoints; with one of them it stands.")
      .def(py::init<double, double, std::vector<Waypoint>, bool>(), py::arg("radius"), py::arg("height"),
           py::arg("path"), py::arg("repeats") = false) FIELD(radius) FIELD(height) FIELD(path) FIELD(repeats);
  m.def(
      "mover_place",
      [](const Mover& mover, double seconds) {
        check(mover, "the mover");
        const MoverPlace p = place_of(mover, seconds);
        return std::array{p.x, p.y, p.vx, p.vy};
      },
      py::arg("mover"), py::arg("seconds"), "x, y in m and their rates");
}

void bind_docks(py::module_& m) {
  {
    using P = Layout;
    py::class_<P>(m, "Layout", "What stands where on the dock, m and rad (docs/plant.md, Your own layout).")
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

void bind_plant_layout(py::module_& m) {
  bind_places(m);
  bind_movers(m);
  bind_docks(m);
}
