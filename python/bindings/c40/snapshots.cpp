// Snapshots as files have them.
#include <pybind11/stl.h>

#include <string>
#include <utility>

#include "python/bindings/c40/c40.hpp"
#include "python/bindings/interpreter/errors.hpp"
#include "state/archive.hpp"
#include "state/file.hpp"

void bind_snapshots(py::module_& core) {
  python::register_error<state::StateError>(core, "SnapshotError", PyExc_ValueError);
  core.def(
      "to_columns",
      [](std::string rows, std::size_t columns) {
        const std::string how = state::to_columns(rows, {{0, rows.size() / sizeof(std::uint64_t) / columns, columns}});
        return std::pair{py::bytes(rows), py::bytes(how)};
      },
      "A table as a snapshot's file has it, and how each column is written.");
  core.def("from_columns", [](std::string rows, std::size_t columns, const std::string& how) {
    state::from_columns(rows, {{0, rows.size() / sizeof(std::uint64_t) / columns, columns}}, how);
    return py::bytes(rows);
  });
  core.def("kind_of_snapshot", [](const std::string& sealed) { return state::kind_of(sealed); });
}
