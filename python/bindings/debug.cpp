// cmrc._core.debug: stop conditions, steps and reverse execution, as values for Python.
#include "python/bindings/debug.hpp"
#include "python/bindings/interpreter/errors.hpp"

#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include <unistd.h>

#include <chrono>
#include <optional>
#include <string>
#include <system_error>
#include <thread>

#include "debugger/dap_server.hpp"
#include "io/stop.hpp"
#include "machine/debug/expression.hpp"

namespace {

using machine::Time;
using machine::debug::Debugger;
using machine::debug::Step;
using machine::debug::Stop;
using machine::debug::Trigger;
using machine::debug::Value;

py::object value_of(const Value& value) {
  return value.is_float ? py::object(py::float_(value.real)) : py::object(py::int_(value.integer));
}

py::dict dict_of(const Stop& stop) {
  py::list hits;
  for (const machine::debug::Hit& hit : stop.hits)
    hits.append(py::dict(py::arg("number") = hit.trigger, py::arg("chip") = hit.chip, py::arg("text") = hit.text,
                         py::arg("before") = hit.before, py::arg("value") = hit.value, py::arg("pc") = hit.pc));
  return py::dict(py::arg("reason") = std::string(machine::debug::name(stop.reason)),
                  py::arg("time_ps") = stop.time.count(), py::arg("chip") = stop.chip, py::arg("text") = stop.text,
                  py::arg("hits") = hits);
}

Step step_named(const std::string& name) {
  for (const auto& [text, step] :
       {std::pair{"instruction", Step::instruction}, std::pair{"over", Step::over}, std::pair{"line", Step::line},
        std::pair{"next_line", Step::next_line}, std::pair{"out", Step::out}, std::pair{"claim", Step::claim},
        std::pair{"refresh", Step::refresh}, std::pair{"event", Step::event}})
    if (name == text) return step;
  throw py::value_error("step: \"" + name + "\"" +
                        " is unknown; instruction, over, line, next_line, out, claim, refresh or event is expected");
}

Trigger trigger_of(const Debugger& debugger, const py::dict& given) {
  const auto text = [&](const char* key) {
    return given.contains(key) ? given[key].cast<std::string>() : std::string();
  };
  Trigger trigger;
  const std::string kind = text("kind"), on = text("on");
  trigger.kind = kind == "code"       ? Trigger::Kind::code
                 : kind == "word"     ? Trigger::Kind::word
                 : kind == "register" ? Trigger::Kind::processor_register
                 : kind == "event"    ? Trigger::Kind::event
                                      : Trigger::Kind::value;
  if (!on.empty())
    trigger.on = on == "read"     ? Trigger::On::read
                 : on == "access" ? Trigger::On::access
                 : on == "change" ? Trigger::On::change
                                  : Trigger::On::write;
  if (given.contains("chip")) trigger.chip = given["chip"].cast<std::optional<std::size_t>>();
  if (given.contains("address")) trigger.address = given["address"].cast<c40::Address>();
  if (trigger.kind == Trigger::Kind::code && given.contains("place"))
    trigger.places = machine::debug::code_named(debugger.programs(), trigger.chip, text("place"));
  else if (trigger.kind == Trigger::Kind::code)
    trigger.places = {{std::nullopt, trigger.address}};
  if (given.contains("words")) trigger.words = given["words"].cast<c40::Word>();
  if (given.contains("ignore")) trigger.ignore = given["ignore"].cast<std::uint64_t>();
  if (given.contains("fields"))
    for (const auto& [key, value] : given["fields"].cast<std::map<std::string, std::string>>())
      trigger.fields.emplace(key, value);
  trigger.name = text("name"), trigger.condition = text("condition"), trigger.log = text("log"),
  trigger.text = text("text");
  return trigger;
}

template <class Work>
py::dict stop_of(PythonDebugger& debugger, const char* call, Work work) {
  debugger.long_work(call, [&](Debugger& x) { work(x); });
  return dict_of(debugger.get(call).stop());
}

py::list shown(const std::vector<machine::debug::ShownRegister>& all) {
  py::list out;
  for (const auto& reg : all) out.append(py::make_tuple(reg.name, reg.hex, reg.value, reg.parts));
  return out;
}

}  // namespace

void bind_debug(py::module_& core) {
  auto m = core.def_submodule("debug", "The debugger. Times are picoseconds.");
  python::register_error<machine::debug::DebugError>(m, "DebugError", PyExc_ValueError);
  py::class_<PythonDebugger>(m, "Debugger", "Stop conditions, steps and time backwards over chips in one virtual time.")
      .def(
          "places",
          [](PythonDebugger& d, std::size_t chip, const std::string& text) {
            return machine::debug::places_named(d.get("places").programs(), chip, text);
          },
          py::arg("chip"), py::arg("text"))
      .def(
          "add",
          [](PythonDebugger& d, const py::dict& trigger) {
            Debugger& x = d.get("add");
            return x.add(trigger_of(x, trigger));
          },
          py::arg("trigger"))
      .def(
          "remove", [](PythonDebugger& d, unsigned number) { d.get("remove").remove(number); }, py::arg("number"))
      .def(
          "enable", [](PythonDebugger& d, unsigned number, bool on) { d.get("enable").enable(number, on); },
          py::arg("number"), py::arg("on"))
      .def("hits",
           [](PythonDebugger& d) {
             std::map<unsigned, std::uint64_t> hits;
             for (const auto& [number, trigger] : d.get("hits").triggers()) hits[number] = trigger.hits;
             return hits;
           })
      .def("stop", [](PythonDebugger& d) { return dict_of(d.get("stop").stop()); })
      .def(
          "go",
          [](PythonDebugger& d, std::optional<std::int64_t> until) {
            return stop_of(d, "go", [&](Debugger& x) { x.go(until ? Time{*until} : machine::never); });
          },
          py::arg("until"))
      .def(
          "step",
          [](PythonDebugger& d, std::size_t chip, const std::string& step) {
            return stop_of(d, "step", [&, s = step_named(step)](Debugger& x) { x.step(chip, s); });
          },
          py::arg("chip"), py::arg("step"))
      .def("go_back", [](PythonDebugger& d) { return stop_of(d, "go_back", [](Debugger& x) { x.go_back(); }); })
      .def(
          "step_back",
          [](PythonDebugger& d, std::size_t chip, const std::string& step) {
            return stop_of(d, "step_back", [&, s = step_named(step)](Debugger& x) { x.step_back(chip, s); });
          },
          py::arg("chip"), py::arg("step"))
      .def(
          "go_to",
          [](PythonDebugger& d, std::int64_t time) {
            return stop_of(d, "go_to", [&](Debugger& x) { x.go_to(Time{time}); });
          },
          py::arg("time"))
      .def(
          "last_write",
          [](PythonDebugger& d, std::size_t chip, c40::Address address) -> py::object {
            std::optional<machine::debug::Writer> writer;
            d.long_work("last_write", [&](Debugger& x) { writer = x.last_write(chip, address); });
            if (!writer) return py::none();
            return py::dict(py::arg("time_ps") = writer->time.count(), py::arg("chip") = writer->chip,
                            py::arg("pc") = writer->pc, py::arg("before") = writer->before,
                            py::arg("value") = writer->value, py::arg("text") = writer->text);
          },
          py::arg("chip"), py::arg("address"))
      .def(
          "set_word",
          [](PythonDebugger& d, std::size_t chip, c40::Address address, c40::Word value) {
            d.get("set_word").set_word(chip, address, value);
          },
          py::arg("chip"), py::arg("address"), py::arg("value"))
      .def(
          "set_register",
          [](PythonDebugger& d, std::size_t chip, const std::string& name, const std::string& expression) {
            d.get("set_register").set_register(chip, name, expression);
          },
          py::arg("chip"), py::arg("name"), py::arg("expression"))
      .def(
          "evaluate",
          [](PythonDebugger& d, std::size_t chip, const std::string& text) {
            Debugger& x = d.get("evaluate");
            return value_of(machine::debug::Expression(text, x.debuggee(), x.programs(), chip).value());
          },
          py::arg("chip"), py::arg("text"))
      .def(
          "peek",
          [](PythonDebugger& d, std::size_t chip, c40::Address address) {
            return d.get("peek").debuggee().peek(chip, address);
          },
          py::arg("chip"), py::arg("address"))
      .def(
          "registers",
          [](PythonDebugger& d, std::size_t chip) {
            return shown(machine::debug::registers(d.get("registers").debuggee().chip(chip)));
          },
          py::arg("chip"))
      .def(
          "peripherals",
          [](PythonDebugger& d, std::size_t chip) {
            return shown(machine::debug::peripherals(d.get("peripherals").debuggee().chip(chip)));
          },
          py::arg("chip"))
      .def(
          "stack",
          [](PythonDebugger& d, std::size_t chip) {
            const auto& program = d.get("stack").program(chip);
            py::list out;
            for (const machine::debug::Frame& frame :
                 machine::debug::call_stack(d.get("stack").debuggee(), chip, program)) {
              const auto source = program.source(frame.pc);
              out.append(py::make_tuple(frame.pc, program.name(frame.pc), source ? source->file : "",
                                        source ? source->line : 0));
            }
            return out;
          },
          py::arg("chip"))
      .def(
          "instruction",
          [](PythonDebugger& d, std::size_t chip, c40::Address address) -> std::optional<std::string> {
            const auto word = d.get("instruction").debuggee().peek(chip, address);
            if (!word) return std::nullopt;
            return d.get("instruction").program(chip).disassembled(address, *word);
          },
          py::arg("chip"), py::arg("address"))
      .def(
          "describe", [](PythonDebugger& d, std::size_t chip) { return d.get("describe").debuggee().describe(chip); },
          py::arg("chip"))
      .def("chip_names",
           [](PythonDebugger& d) {
             std::vector<std::string> names;
             for (std::size_t n = 0; n < d.get("chip_names").programs().size(); ++n)
               names.push_back(d.get("chip_names").debuggee().chip_name(n));
             return names;
           })
      .def("event_kinds",
           [](PythonDebugger& d) {
             std::vector<std::pair<std::string, std::string>> kinds;
             for (const machine::debug::EventKind& kind : d.get("event_kinds").event_kinds())
               kinds.emplace_back(kind.name, kind.what);
             return kinds;
           })
      .def("value_names", [](PythonDebugger& d) { return d.get("value_names").debuggee().value_names(); })
      .def(
          "page", [](PythonDebugger& d, const std::string& name) { return d.get("page").debuggee().page(name); },
          py::arg("name"))
      .def("history",
           [](PythonDebugger& d) {
             const auto info = d.get("history").history();
             return py::dict(py::arg("snapshots") = info.snapshots, py::arg("bytes") = info.bytes,
                             py::arg("first_ps") = info.first.count(), py::arg("last_ps") = info.last.count());
           })
      .def(
          "listen",
          [](PythonDebugger& d, int port, const py::object& heard) {
            std::optional<debugger::dap::Listener> opened;
            try {
              opened.emplace(port);
            } catch (const std::system_error& error) {
              PyErr_SetString(PyExc_OSError, error.what());
              throw py::error_already_set();
            }
            debugger::dap::Listener& listener = *opened;
            if (!heard.is_none()) heard(listener.port());
            return d.long_work("listen", [&](Debugger& x) {
              while (!listener.has_client()) {
                if (io::stop_asked()) return false;
                std::this_thread::sleep_for(std::chrono::milliseconds{20});
              }
              const int client = listener.accept();
              if (client < 0) return false;
              const debugger::dap::Ended ended = debugger::dap::serve(client, client, x);
              ::close(client);
              return !ended.terminate;
            });
          },
          py::arg("port"), py::arg("heard"), "Serves one editor until it goes; False: it wants the run to end.")
      .def("changes", [](PythonDebugger& d) { return d.get("changes").changes(); })
      .def(
          "state", [](PythonDebugger& d) { return py::bytes(d.get("state").debuggee().save()); },
          "The whole state, for comparisons.")
      .def(
          "on_output",
          [](PythonDebugger& d, const py::object& heard) {
            Debugger& x = d.get("on_output");
            if (heard.is_none()) return void(x.output = {});
            x.output = [heard](const std::string& text) {
              const py::gil_scoped_acquire gil;
              heard(text);
            };
          },
          py::arg("heard"));
}
