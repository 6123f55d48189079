// What a bus tells of its attempts, and its statistics.
#include <pybind11/stl.h>

#include "bus_model/bus.hpp"
#include "bus_model/statistics.hpp"
#include "tests/bindings/bindings.hpp"

using namespace pci;

void bind_bus_statistics(py::module_& m) {
  py::class_<Attempt>(m, "Attempt")
      .def_readonly("master", &Attempt::master)
      .def_readonly("target", &Attempt::target)
      .def_readonly("kind", &Attempt::kind)
      .def_readonly("write", &Attempt::write)
      .def_readonly("address", &Attempt::address)
      .def_readonly("wanted", &Attempt::wanted)
      .def_readonly("words", &Attempt::words)
      .def_readonly("requested", &Attempt::requested)
      .def_readonly("frame", &Attempt::frame)
      .def_readonly("first", &Attempt::first)
      .def_readonly("last", &Attempt::last);
  py::class_<Histogram> histogram(m, "Histogram");
  histogram.def(py::init<>())
      .def("count", &Histogram::count)
      .def("sum", &Histogram::sum)
      .def("max", &Histogram::max)
      .def("percentile", &Histogram::percentile, py::arg("fraction"))
      .def("octaves", &Histogram::octaves)
      .def("add", &Histogram::add);
  py::class_<BusStatistics>(m, "BusStatistics")
      .def_readonly("address", &BusStatistics::address)
      .def_readonly("data", &BusStatistics::data)
      .def_readonly("wait", &BusStatistics::wait)
      .def_readonly("turnaround", &BusStatistics::turnaround)
      .def_readonly("idle_requested", &BusStatistics::idle_requested)
      .def_readonly("idle", &BusStatistics::idle)
      .def("total", &BusStatistics::total);
  py::class_<MasterStatistics>(m, "MasterStatistics")
      .def_readonly("transactions", &MasterStatistics::transactions)
      .def_readonly("words_read", &MasterStatistics::words_read)
      .def_readonly("words_written", &MasterStatistics::words_written)
      .def_readonly("retries", &MasterStatistics::retries)
      .def_readonly("disconnects", &MasterStatistics::disconnects)
      .def_readonly("timer_stops", &MasterStatistics::timer_stops)
      .def_readonly("aborts", &MasterStatistics::aborts)
      .def_readonly("owned", &MasterStatistics::owned)
      .def_readonly("arbitration", &MasterStatistics::arbitration)
      .def_readonly("acquisition", &MasterStatistics::acquisition)
      .def_readonly("target", &MasterStatistics::target)
      .def_readonly("wait", &MasterStatistics::wait);
  py::class_<TargetStatistics>(m, "TargetStatistics")
      .def_readonly("words_read", &TargetStatistics::words_read)
      .def_readonly("words_written", &TargetStatistics::words_written)
      .def_readonly("retries", &TargetStatistics::retries);
}
