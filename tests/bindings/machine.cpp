// Several DSPs on their buses with a host that follows a script.
#include "machine/system/machine.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <tuple>
#include <vector>

#include "bus_model/bus.hpp"
#include "c40/chip/chip.hpp"
#include "machine/chips/chip_stop.hpp"
#include "machine/system/host_program.hpp"
#include "machine/system/machine_config.hpp"
#include "machine/system/observer.hpp"
#include "machine/system/scripted_events.hpp"
#include "plant/dock/dock.hpp"
#include "tests/bindings/bindings.hpp"
#include "toolchain/objects/image.hpp"

namespace {

using namespace machine;

// At each time of its script the host writes some words and then, if asked, reads some.
struct ScriptedHost final : HostProgram {
  struct Step {
    std::int64_t time;
    Offset offset;
    std::vector<Word> words;
    unsigned read;
  };
  Time next_wake() const override { return done < steps.size() && !waiting ? Time{steps[done].time} : machine::never; }
  void wake(Time, HostPort& port) override {
    const Step& step = steps[done++];
    if (!step.words.empty()) port.write(step.offset, step.words);
    if (step.read == 0) return;
    port.read(step.offset, step.read, static_cast<std::uint32_t>(done - 1));
    waiting = true;
  }
  void read_done(std::uint32_t tag, std::span<const Word> words, Time now, HostPort&) override {
    waiting = false;
    reads.emplace_back(steps.at(tag).time, now.count(), std::vector<Word>{words.begin(), words.end()});
  }
  std::vector<Step> steps;
  std::size_t done = 0;
  bool waiting = false;
  std::vector<std::tuple<std::int64_t, std::int64_t, std::vector<Word>>> reads;
};

using Logged = std::tuple<std::int64_t, std::string, std::vector<std::int64_t>>;

struct Recorder final : Observer {
  void add(Time now, std::string what, std::vector<std::int64_t> values) {
    events.emplace_back(now.count(), std::move(what), std::move(values));
  }
  void dsp_write(unsigned slot, Window bus, Offset offset, Word value, Time issued, Time now) override {
    add(now, "write", {slot, static_cast<int>(bus), offset, value, issued.count()});
  }
  void dsp_write_dropped(unsigned slot, Window bus, Offset offset, Word value, Time issued, Time now) override {
    add(now, "dropped", {slot, static_cast<int>(bus), offset, value, issued.count()});
  }
  void transaction(BusId bus, const pci::Transaction& t, Time now) override {
    add(now, "transaction",
        {static_cast<int>(bus), t.master, t.address, t.words, t.write, static_cast<int>(t.result), t.requested,
         t.framed, t.ended, static_cast<std::int64_t>(t.number)});
  }
  void interrupt(unsigned slot, int pin, Time now) override { add(now, "interrupt", {slot, pin}); }
  void semaphore(unsigned number, SemaphoreEvent event, unsigned owner, Time now) override {
    add(now, "semaphore", {number, static_cast<int>(event), owner});
  }
  void fault(const ChipFault& fault) override {
    add(fault.time, "fault", {fault.slot, fault.pc, fault.address, fault.cycle});
  }
  void link_lost(unsigned slot, bool to_dsp, Word word, int bytes, Time now) override {
    add(now, "link_lost", {slot, to_dsp, word, bytes});
  }
  void slot(unsigned number, SlotChange change, Time now) override {
    add(now, "slot", {number, static_cast<int>(change)});
  }
  std::vector<Logged> events;
};

class PyMachine {
 public:
  PyMachine(const toolchain::Image& program, const Config& config, plant::Dock* dock,
            const std::vector<std::tuple<std::int64_t, Offset, std::vector<Word>, unsigned>>& host_script, bool record)
      : machine{config, program, dock, prepare(host_script)} {
    if (record) machine.set_observer(&recorder);
  }
  std::vector<std::uint64_t> state() const {
    std::vector<std::uint64_t> words;
    machine.append_state(words);
    return words;
  }
  ScriptedHost host;
  Recorder recorder;
  Machine machine;

 private:
  HostProgram* prepare(const std::vector<std::tuple<std::int64_t, Offset, std::vector<Word>, unsigned>>& script) {
    for (const auto& [time, offset, words, read] : script) host.steps.push_back({time, offset, words, read});
    std::stable_sort(host.steps.begin(), host.steps.end(),
                     [](const auto& a, const auto& b) { return a.time < b.time; });
    return host.steps.empty() ? nullptr : &host;
  }
};

py::dict causes_of(const c40::Chip& chip) {
  py::dict result;
  for (std::size_t i = 0; i < c40::cause_count; ++i)
    result[py::str(std::string{c40::name(static_cast<c40::Cause>(i))})] = chip.causes()[i];
  return result;
}

/// Every reason that has a name: which are all, or chip.cpp would not compile.
void bind_stops(py::module_& m) {
  py::dict meanings;
  for (int i = 0; !c40::name(static_cast<c40::StopInfo::Reason>(i)).empty(); ++i) {
    const auto reason = static_cast<c40::StopInfo::Reason>(i);
    meanings[py::str(std::string(c40::name(reason)))] = std::string(name(meaning(reason)));
  }
  m.attr("stop_meanings") = meanings;
}

}  // namespace

void bind_machine(py::module_& test) {
  py::module_ m = test.def_submodule(
      "machine", "DSPs, buses, shared memory and devices in one virtual time. Times are integer picoseconds.");
  bind_machine_settings(m);
  bind_stops(m);
  py::class_<PyMachine>(m, "Machine")
      .def(py::init<const toolchain::Image&, const Config&, plant::Dock*,
                    const std::vector<std::tuple<std::int64_t, Offset, std::vector<Word>, unsigned>>&, bool>(),
           py::arg("program"), py::arg("config") = Config{}, py::arg("dock").none(true) = nullptr,
           py::arg("host") = std::vector<std::tuple<std::int64_t, Offset, std::vector<Word>, unsigned>>{},
           py::arg("record") = false, py::keep_alive<1, 4>(),
           "host: steps (time, bus A offset, words to write, number of words to read), none: no host. record: keep "
           "`events`.")
      .def(
          "run_until", [](PyMachine& self, std::int64_t time) { self.machine.run_until(Time{time}); }, py::arg("time"),
          py::call_guard<py::gil_scoped_release>())
      .def_property_readonly("time", [](const PyMachine& self) { return self.machine.time().count(); })
      .def(
          "act",
          [](PyMachine& self, Action action, unsigned number, std::int64_t amount) {
            self.machine.act({{}, action, number, amount});
          },
          py::arg("action"), py::arg("number"), py::arg("amount") = 0)
      .def("peek", [](const PyMachine& self, Offset offset) { return self.machine.peek(offset); })
      .def("poke", [](PyMachine& self, Offset offset, Word word) { self.machine.poke(offset, word); })
      .def("causes", [](const PyMachine& self, unsigned slot) { return causes_of(self.machine.chip(slot)); })
      .def("cycle", [](const PyMachine& self, unsigned slot) { return self.machine.chip(slot).cycle(); })
      .def("instructions", [](const PyMachine& self, unsigned slot) { return self.machine.chip(slot).instructions(); })
      .def(
          "chip_word",
          [](const PyMachine& self, unsigned slot, std::uint32_t address) {
            return self.machine.chip(slot).peek(address);
          },
          py::arg("slot"), py::arg("address"))
      .def("idle", [](const PyMachine& self, unsigned slot) { return self.machine.chip(slot).idle(); })
      .def("booted", [](const PyMachine& self, unsigned slot) { return self.machine.booted(slot); })
      .def("boot_stream", [](const PyMachine& self, unsigned slot) { return self.machine.boot_stream(slot); })
      .def("audit", [](const PyMachine& self) { return self.machine.audit(); })
      .def("plugged", [](const PyMachine& self, unsigned slot) { return self.machine.plugged(slot); })
      .def("standing", [](const PyMachine& self, unsigned slot) { return self.machine.standing(slot); })
      .def("statistics", [](const PyMachine& self, unsigned slot) { return self.machine.statistics(slot); })
      .def("bus_statistics",
           [](const PyMachine& self, char bus) { return self.machine.bus_statistics(static_cast<BusId>(bus - 'A')); })
      .def_property_readonly("faults", [](const PyMachine& self) { return self.machine.faults(); })
      .def_property_readonly(
          "reads", [](const PyMachine& self) { return self.host.reads; },
          "The host's reads: (time of the step, time of the answer, words).")
      .def_property_readonly("events", [](const PyMachine& self) { return self.recorder.events; })
      .def("state", &PyMachine::state);
}
