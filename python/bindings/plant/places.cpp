// Positions on the dock, and what moves between them.
#include <pybind11/stl.h>

#include "plant/parameters/check.hpp"
#include "plant/parameters/config.hpp"
#include "plant/scene/scene.hpp"
#include "python/bindings/plant/plant.hpp"

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

}  // namespace

void bind_plant_places(py::module_& m) {
  bind_places(m);
  bind_movers(m);
}
