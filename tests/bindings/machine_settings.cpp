// How a machine is set, and what it tells of its slots.
#include <pybind11/stl.h>

#include "machine/system/machine.hpp"
#include "machine/system/machine_config.hpp"
#include "machine/system/observer.hpp"
#include "machine/system/scripted_events.hpp"
#include "tests/bindings/bindings.hpp"

using namespace machine;

namespace {

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
      .def_readwrite("instant_access", &Config::instant_access)
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
      .def_readonly("boots", &SlotStatistics::boots)
      .def_readonly("words_to_dsp", &SlotStatistics::words_to_dsp)
      .def_readonly("words_from_dsp", &SlotStatistics::words_from_dsp)
      .def_readonly("words_lost", &SlotStatistics::words_lost);
}

}  // namespace

void bind_machine_settings(py::module_& m) {
  bind_actions(m);
  bind_config(m);
}
