// Several DSPs on their buses with a host that follows a script.
#include "machine/machine.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <tuple>
#include <vector>

#include "bus_model/bus.hpp"
#include "c40/chip.hpp"
#include "machine/chip_stop.hpp"
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

void bind_actions(py::module_& m) {
  py::enum_<Action>(m, "Action")
      .value("fail", Action::fail)
      .value("freeze", Action::freeze)
      .value("hang", Action::hang)
      .value("unplug", Action::unplug)
      .value("plug", Action::plug)
      .value("reset", Action::reset)
      .value("link", Action::link)
      .value("pace", Action::pace)
      .value("pause_host", Action::pause_host)
      .value("stall_bus", Action::stall_bus)
      .value("drive", Action::drive)
      .value("encoder", Action::encoder)
      .value("sway", Action::sway)
      .value("second_sway", Action::second_sway)
      .value("drive_status", Action::drive_status)
      .value("drive_speed", Action::drive_speed)
      .value("load_cell", Action::load_cell)
      .value("anemometer", Action::anemometer);
  m.def(
      "scripted_actions",
      [] {
        py::list all;
        for (const ScriptedAction& row : scripted_actions())
          all.append(py::make_tuple(row.action, std::string{row.name}, std::string{row.undo}));
        return all;
      },
      "Each action, its word, and the word that undoes it where there is one.");
}

void bind_config(py::module_& m) {
  py::enum_<Boot>(m, "Boot").value("preloaded", Boot::preloaded).value("link", Boot::link);
  py::class_<Topology>(m, "Topology", "Which agent stands on which bus; buses are numbered as in `buses`.")
      .def(py::init<>())
      .def_readwrite("buses", &Topology::buses)
      .def_readwrite("host", &Topology::host)
      .def_readwrite("dsps", &Topology::dsps)
      .def_readwrite("shared_memory", &Topology::shared_memory)
      .def_readwrite("devices", &Topology::devices)
      .def_readwrite("devices_at", &Topology::devices_at)
      .def_readwrite("bridges", &Topology::bridges);
  py::class_<Config>(m, "Config", "All parameters of a machine; times in picoseconds.")
      .def(py::init<>())
      .def_readwrite("dsps", &Config::dsps)
      .def_readwrite("slots", &Config::slots)
      .def_readwrite("chip_hz", &Config::chip_hz)
      .def_readwrite("pci_hz_numerator", &Config::pci_hz_numerator)
      .def_readwrite("pci_hz_denominator", &Config::pci_hz_denominator)
      .def_readwrite("boot", &Config::boot)
      .def_readwrite("idle_policy", &Config::idle_policy)
      .def_readwrite("pause_count", &Config::pause_count)
      .def_readwrite("interrupt_clocks", &Config::interrupt_clocks)
      .def_readwrite("bus", &Config::bus)
      .def_readwrite("topology", &Config::topology)
      .def_readwrite("bus_bridge", &Config::bus_bridge)
      .def_readwrite("host_master", &Config::host_master)
      .def_readwrite("dsp_master", &Config::dsp_master)
      .def_readwrite("bridge_a", &Config::bridge_a)
      .def_readwrite("bridge_b", &Config::bridge_b)
      .def_readwrite("host_bridge", &Config::host_bridge)
      .def_readwrite("turn_order", &Config::turn_order)
      .def(
          "script",
          [](Config& config, std::int64_t time, Action action, unsigned number, std::int64_t amount) {
            config.script.push_back({Time{time}, action, number, amount});
          },
          py::arg("time"), py::arg("action"), py::arg("number"), py::arg("amount") = 0);
  py::class_<ChipFault>(m, "ChipFault")
      .def_readonly("slot", &ChipFault::slot)
      .def_readonly("cycle", &ChipFault::cycle)
      .def_readonly("pc", &ChipFault::pc)
      .def_readonly("address", &ChipFault::address)
      .def_readonly("message", &ChipFault::message)
      .def_property_readonly("time", [](const ChipFault& fault) { return fault.time.count(); });
  py::class_<SlotStatistics>(m, "SlotStatistics")
      .def_readonly("posted_writes", &SlotStatistics::posted_writes)
      .def_readonly("bus_reads", &SlotStatistics::bus_reads)
      .def_readonly("prefetch_hits", &SlotStatistics::prefetch_hits)
      .def_readonly("dropped_writes", &SlotStatistics::dropped_writes)
      .def_readonly("interrupts", &SlotStatistics::interrupts)
      .def_readonly("boots", &SlotStatistics::boots)
      .def_readonly("words_to_dsp", &SlotStatistics::words_to_dsp)
      .def_readonly("words_from_dsp", &SlotStatistics::words_from_dsp)
      .def_readonly("words_lost", &SlotStatistics::words_lost);
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
  bind_actions(m);
  bind_config(m);
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
