// Sensors, wind, the moored ship, and the noise of all of them.
#include <pybind11/native_enum.h>
#include <pybind11/numpy.h>

#include "plant/numerics/noise.hpp"
#include "plant/parameters/check.hpp"
#include "plant/parameters/config.hpp"
#include "plant/scene/wind.hpp"
#include "python/bindings/plant/plant.hpp"

using namespace plant;

namespace {

void bind_sensors(py::module_& m) {
  using P = SensorParameters;
  py::class_<P>(
      m, "SensorParameters",
      "Sway sensor (rad) and range sensors (Hz, probability); seed of their noise (plant-and-bus.md 1.4, 1.5).")
      .def(py::init<>()) FIELD(sway_range) FIELD(sway_noise) FIELD(second_sway) FIELD(range_rate) FIELD(range_dropout)
          FIELD(seed);
}

void bind_weather(py::module_& m) {
  {
    using P = WindParameters;
    py::class_<P>(m, "WindParameters", "Mean and gusts in m/s, direction (towards) in rad, drag area in m2, seed.")
        .def(py::init<>()) FIELD(mean) FIELD(gust) FIELD(direction) FIELD(side_area) FIELD(end_area)
            FIELD(spreader_area) FIELD(seed);
  }
  m.def(
      "wind_speed",
      [](const WindParameters& p, const py::object& seconds) -> py::object {
        check(p);
        return py::vectorize([wind = Wind(p)](double t) mutable { return wind.speed(t); })(
            py::array_t<double>(seconds));
      },
      py::arg("wind"), py::arg("seconds"), "m/s, the mean and the seeded gusts, at an instant or an array of them (s)");
  py::native_enum<Stream>(m, "Stream", "enum.Enum")
      .value("sway_radial", Stream::sway_radial)
      .value("sway_tangential", Stream::sway_tangential)
      .value("second_sway_radial", Stream::second_sway_radial)
      .value("second_sway_tangential", Stream::second_sway_tangential)
      .value("range_dropout", Stream::range_dropout)
      .value("wind_frequency", Stream::wind_frequency)
      .value("wind_phase", Stream::wind_phase)
      .value("ship_surge", Stream::ship_surge)
      .value("ship_sway", Stream::ship_sway)
      .value("ship_heave", Stream::ship_heave)
      .value("ship_roll", Stream::ship_roll)
      .value("ship_pitch", Stream::ship_pitch)
      .finalize();
  m.def("normal", &normal, py::arg("seed"), py::arg("stream"), py::arg("sample"),
        "standard normal deviate of a stream of noise");
  m.def("uniform", &uniform, py::arg("seed"), py::arg("stream"), py::arg("sample"),
        "number between 0 and 1 of a stream of noise");
  using P = ShipMotion;
  py::class_<P>(
      m, "ShipMotion",
      "A moored ship: scale of its motion, m that it rises per kg that leaves it, seed (plant-and-bus.md 1.5).")
      .def(py::init<>()) FIELD(scale) FIELD(draught) FIELD(seed);
}

}  // namespace

void bind_plant_surroundings(py::module_& m) {
  bind_sensors(m);
  bind_weather(m);
}
