// The tables of which one row adds one thing, as pages show them (scripts/documents/figures.py).
#include <pybind11/stl.h>

#include <string>

#include "c40/peripherals/register_map.hpp"
#include "c40/values/types.hpp"
#include "cmrc/tasks/job_kinds.hpp"
#include "tests/bindings/bindings.hpp"

void bind_rows(py::module_& test) {
  test.def(
      "causes",
      [] {
        py::list all;
        for (const c40::CauseRow& row : c40::cause_rows) all.append(py::make_tuple(row.name, row.letter, row.meaning));
        return all;
      },
      "The causes of a chip's cycles: name, letter of the pipeline diagram, meaning.");
  test.def(
      "job_kinds",
      [] {
        py::list all;
        for (const cmrc::KindRow& row : cmrc::kind_rows)
          all.append(py::dict(py::arg("name") = row.name, py::arg("symbol") = row.symbol, py::arg("x") = row.x,
                              py::arg("importance") = row.importance.restored,
                              py::arg("crane_step") = row.step == cmrc::StepOf::crane || row.step == cmrc::StepOf::both,
                              py::arg("agv_step") = row.step == cmrc::StepOf::agv || row.step == cmrc::StepOf::both));
        return all;
      },
      "The rows of the kinds of jobs.");
  test.def(
      "peripheral_registers",
      [] {
        py::list all;
        for (const c40::RegisterInfo& info : c40::register_map()) {
          py::dict fields;
          for (const c40::Field& field : info.fields)
            fields[py::str(std::string(field.name))] = py::make_tuple(field.low, field.width);
          all.append(py::dict(py::arg("name") = info.name, py::arg("address") = info.address,
                              py::arg("reset") = info.reset, py::arg("fields") = fields,
                              py::arg("meaning") = std::string(info.meaning)));
        }
        return all;
      },
      "Every memory-mapped register: name, address, value after reset, fields (lowest bit, width).");
}
