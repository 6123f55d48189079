#include "python/bindings/bindings.hpp"
#include "report/events/event_log.hpp"

void bind_report(py::module_& core) {
  using namespace py::literals;
  py::module_ room = core.def_submodule("report", "What an event's numbers mean.");

  room.def(
      "event_names",
      [] {
        py::dict all;
        for (unsigned number = 1; number < 256; ++number) {
          const auto kind = static_cast<report::EventKind>(number);
          py::list arguments;
          for (const std::string_view argument : report::argument_names(kind)) {
            if (!argument.empty()) arguments.append(std::string(argument));
          }
          if (!report::name(kind).starts_with("event ")) all[py::int_(number)] = py::make_tuple(name(kind), arguments);
        }
        return all;
      },
      "By number of an event its name and its arguments' names.");
  room.def(
      "component_name", [](unsigned component) { return report::name(static_cast<report::Component>(component)); },
      "component"_a);
}
