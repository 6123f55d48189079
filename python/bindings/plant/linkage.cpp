// The level-luffing jib by itself.
#include <pybind11/stl.h>

#include "plant/crane/linkage.hpp"
#include "python/bindings/plant/plant.hpp"

using namespace plant;

void bind_plant_linkage(py::module_& m) {
  using P = LinkageParameters;
  py::class_<P>(m, "LinkageParameters", "Bars in m, masses in kg (plant/crane/linkage.hpp).")
      .def(py::init<>()) FIELD(jib) FIELD(jib_mass) FIELD(fly) FIELD(fly_mass) FIELD(back) FIELD(tie) FIELD(tie_mass)
          FIELD(base_x) FIELD(base_z) FIELD(load);
  py::class_<Linkage>(m, "Linkage", "A level-luffing double-link jib in its plane, by IDA.")
      .def(py::init<const LinkageParameters&, double>(), py::arg("parameters"), py::arg("tolerance") = 1e-9)
      .def("place", &Linkage::place, py::arg("jib_angle"), py::arg("jib_rate") = 0.0)
      .def("advance", &Linkage::advance, py::arg("torque"), py::arg("seconds"))
      .def_property_readonly("angles", &Linkage::angles)
      .def_property_readonly("rates", &Linkage::rates)
      .def_property_readonly("nose", &Linkage::nose)
      .def_property_readonly("open", &Linkage::open)
      .def_property_readonly("energy", &Linkage::energy)
      .def_property_readonly("holding_torque", &Linkage::holding_torque)
      .def_property_readonly("joint_force", &Linkage::joint_force);
}
