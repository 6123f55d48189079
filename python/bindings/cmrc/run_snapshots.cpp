// cmrc._core.cmrc: what a run leaves for others, its snapshots and its ideal run.
#include <memory>
#include <string_view>

#include "cmrc/run/simulation.hpp"
#include "python/bindings/cmrc/cmrc.hpp"
#include "report/events/event.hpp"

void bind_run_snapshots(py::module_& m) {
  py::class_<cmrc::Reference, std::shared_ptr<cmrc::Reference>>(
      m, "Reference", "An ideal run, for the runs that are measured against it.")
      .def_readonly("elapsed_s", &cmrc::Reference::elapsed_s);
  py::class_<cmrc::Snapshot>(m, "Snapshot", "A run at an instant; opaque.")
      .def_property_readonly("time_s", [](const cmrc::Snapshot& s) { return report::seconds(s.time()); })
      .def_property_readonly("configuration", &cmrc::Snapshot::configuration)
      .def_property_readonly("state", [](const cmrc::Snapshot& s) { return py::bytes(s.state()); })
      .def("to_bytes", [](const cmrc::Snapshot& s) { return py::bytes(s.to_bytes()); })
      .def_static(
          "from_bytes", [](const py::bytes& bytes) { return cmrc::Snapshot::from_bytes(std::string_view(bytes)); },
          py::arg("bytes"))
      .def(py::pickle([](const cmrc::Snapshot& s) { return py::bytes(s.to_bytes()); },
                      [](const py::bytes& bytes) { return cmrc::Snapshot::from_bytes(std::string_view(bytes)); }));
}
