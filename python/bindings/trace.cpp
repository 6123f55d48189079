#include <pybind11/stl.h>

#include <optional>
#include <sstream>

#include "isa/types.hpp"
#include "machine/program_text/instruction_trace.hpp"
#include "python/bindings/bindings.hpp"
#include "report/events/trace_text.hpp"

namespace {

/// The record of cmrc._core.c40.Processor.trace() back as the struct that the text is made of.
std::string trace_line(const py::dict& record, unsigned slot, const machine::Labels* labels) {
  c40::Causes causes{};
  std::size_t cause = 0;
  for (const auto& item : record["causes"].cast<py::dict>()) causes.at(cause++) = item.second.cast<c40::Cycles>();
  if (record.contains("interrupt"))
    return machine::to_text(
        c40::InterruptRecord{record["cycle"].cast<c40::Cycles>(), record["interrupt"].cast<c40::Word>(), causes}, slot);
  c40::TraceRecord out;
  out.cycle = record["cycle"].cast<c40::Cycles>();
  out.pc = record["pc"].cast<c40::Address>();
  out.word = record["word"].cast<c40::Word>();
  out.cycles = record["cycles"].cast<c40::Cycles>();
  out.causes = causes;
  std::vector<c40::RegisterChange> registers;
  for (const auto& item : record["registers"].cast<py::dict>()) {
    const auto reg = isa::register_named(item.first.cast<std::string>());
    if (!reg) throw py::key_error(item.first.cast<std::string>());
    registers.push_back({*reg, item.second.cast<std::uint64_t>()});
  }
  std::vector<c40::MemoryEvent> memory;
  for (const auto& item : record["memory"]) {
    const auto event = item.cast<py::tuple>();
    memory.push_back({event[1].cast<c40::Address>(), event[2].cast<c40::Word>(), event[0].cast<std::string>() == "w"});
  }
  out.registers = registers;
  out.memory = memory;
  return labels ? machine::to_text(out, slot, *labels) : machine::to_text(out, slot);
}

std::optional<py::dict> difference(const std::string& left, const std::string& right) {
  std::istringstream one(left), other(right);
  const auto found = report::compare_traces(one, other);
  if (!found) return std::nullopt;
  const auto& line = found->left ? found->left : found->right;
  const auto text = [](const std::optional<report::TraceLine>& of) {
    return of ? py::object(py::str(of->text)) : py::object(py::none());
  };
  using namespace py::literals;
  return py::dict("when"_a = line->when, "component"_a = line->who, "field"_a = found->field,
                  "left"_a = found->left_value, "right"_a = found->right_value, "left_line"_a = text(found->left),
                  "right_line"_a = text(found->right));
}

}  // namespace

void bind_trace(py::module_& core) {
  py::module_ room = core.def_submodule("trace", "Text traces (docs/trace.md).");
  py::class_<machine::Labels>(room, "Labels",
                              "What a program calls things, for traces that stay the same when it moves.")
      .def(py::init(&machine::Labels::of_program), py::arg("image"))
      .def_static("of_dock", &machine::Labels::of_dock, py::arg("image"),
                  "Of the image of the dock's DSPs: also RAM on chip and the windows.")
      .def(
          "name", [](const machine::Labels& labels, c40::Address address) { return labels.names.text(address); },
          py::arg("address"), "Label and offset; eight hexadecimal digits where nothing has a name.");
  room.def(
      "difference", &difference, py::arg("left"), py::arg("right"),
      "Where two traces part: when, component, field, both values and lines (None: that trace has ended). None where "
      "they are alike. Raises ValueError for a text that is no trace.");
  room.def("line", &trace_line, py::arg("record"), py::arg("slot") = 0, py::arg("labels") = nullptr,
           "The line of an instruction or an interrupt, from a record of c40.Processor.trace().");
}
