// The tables of which one row adds one thing, as pages show them (scripts/doc_figures.py).
#include <pybind11/stl.h>

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
}
