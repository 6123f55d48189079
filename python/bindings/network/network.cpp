// cmrc._core.network: chips, links, memories in one virtual time.
#include "machine/networks/network.hpp"
#include "machine/debug/network_debuggee.hpp"

#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "python/bindings/bindings.hpp"
#include "python/bindings/c40/chip_inspection.hpp"
#include "python/bindings/c40/devices.hpp"
#include "python/bindings/debug.hpp"
#include "python/bindings/interpreter/ctrl_c.hpp"
#include "python/bindings/interpreter/errors.hpp"
#include "python/bindings/interpreter/state.hpp"
#include "python/bindings/network/network.hpp"
#include "state/archive.hpp"
#include "state/file.hpp"

namespace {

using machine::NetworkAction;
using machine::NetworkDescription;
using machine::Time;

struct ChipOf {
  std::shared_ptr<machine::Network> network;
  std::size_t number;
};

/// The chip, for reading and for changing.
struct ChipOfNetwork {
  c40::Chip& operator()(const ChipOf& c) const { return c.network->chip(c.number); }
  void poke(ChipOf& c, c40::Address address, c40::Word value) const { c.network->poke(c.number, address, value); }
  void changed(ChipOf& c) const { c.network->changed_by_hand(); }
};

py::dict link_of(const machine::Network& network, std::size_t n) {
  const c40::Link& link = network.link(n);
  const auto side = [&](int s) {
    const auto& c = link.counters(s);
    return py::dict(py::arg("sent") = c.sent, py::arg("arrived") = c.arrived, py::arg("under_way") = link.under_way(s),
                    py::arg("lost") = c.lost, py::arg("tokens") = c.tokens);
  };
  const machine::NetworkLink& ends = network.ends(n);
  return py::dict(py::arg("a") = std::pair{ends.a.chip, ends.a.port},
                  py::arg("b") = std::pair{ends.b.chip, ends.b.port}, py::arg("cut") = link.is_cut(),
                  py::arg("token_lost") = link.is_dead(), py::arg("forth") = side(0), py::arg("back") = side(1));
}

}  // namespace

void bind_network(py::module_& core) {
  auto m =
      core.def_submodule("network", "Networks of chips joined by their communication ports. Times are picoseconds.");
  python::register_error<machine::NetworkError>(m, "NetworkError", PyExc_ValueError);

  m.def(
      "chips_of",
      [](const std::string& topology) {
        NetworkDescription d;
        return machine::set_topology(d, topology);
      },
      "How many chips a topology has.");

  py::class_<ChipOf> chip(m, "Chip", "One chip of a network.");
  chip.def_property_readonly("pc", [](const ChipOf& c) { return c.network->chip(c.number).pc(); })
      .def_property_readonly("name", [](const ChipOf& c) { return c.network->chip_name(c.number); })
      .def_property_readonly("status",
                             [](const ChipOf& c) { return std::string(machine::name(c.network->status(c.number))); })
      .def_property_readonly("message", [](const ChipOf& c) { return c.network->describe(c.number); })
      .def_property_readonly("reserved_accesses",
                             [](const ChipOf& c) { return reserved_accesses(c.network->ignored(c.number)); })
      .def_property_readonly("waits_for", [](const ChipOf& c) { return c.network->waits_for(c.number); })
      .def_property_readonly("hertz", [](const ChipOf& c) { return c.network->clock(c.number).hertz(); });
  bind_inspection(chip, ChipOfNetwork());
  bind_devices(
      chip, [](ChipOf& c) { return c.network->devices(c.number); },
      [](ChipOf& c) { return c.network->present_cycle(c.number); });

  py::class_<machine::Network, std::shared_ptr<machine::Network>> network_class(m, "Network");
  bind_state<machine::Network>(network_class);
  network_class
      .def(py::init(&made_network), py::arg("chips"), py::arg("links"), py::arg("topology"), py::arg("memories"),
           py::arg("nets"), py::arg("turn_order"))
      .def(py::init(&network_from_file), py::arg("path"), py::arg("program"), py::arg("turn_order"),
           "From a file; `program` reads one by its path.")
      .def("program", [](const machine::Network& network, std::size_t n) { return network.program(n); })
      .def("save",
           [](const machine::Network& network) {
             return py::bytes(state::seal("network", network.configuration(), state::save_with_tables(network)));
           })
      .def(
          "load",
          [](machine::Network& network, const std::string& sealed) {
            state::load_or_leave(network, state::opened(sealed, "network", network.configuration()).text);
          },
          "Raises an error for data that is not a snapshot of such a network; nothing is changed then.")
      .def("debug",
           [](const std::shared_ptr<machine::Network>& network) {
             for (std::size_t n = 0; n < network->chip_count(); ++n)
               if (machine::BoardDevices* devices = network->devices(n); devices != nullptr && devices->stateless())
                 throw state::StateError(*devices->stateless());
             return std::make_unique<PythonDebugger>(network,
                                                     std::make_unique<machine::debug::NetworkDebuggee>(*network), true);
           })
      .def("record_peripherals", &machine::Network::record_peripherals, py::arg("on"))
      .def("event_trace", &machine::Network::event_trace)
      .def("peripheral_events",
           [](const machine::Network& network) {
             py::list out;
             for (const machine::ChipEvent& e : network.peripheral_events())
               out.append(py::dict(py::arg("chip") = e.chip, py::arg("time_ps") = e.time.count(),
                                   py::arg("kind") = std::string(name(e.event.kind)), py::arg("cycle") = e.event.cycle,
                                   py::arg("number") = e.event.number, py::arg("value") = e.event.value,
                                   py::arg("channel") = e.event.channel < 0 ? std::optional<int>{} : e.event.channel));
             return out;
           })
      .def(
          "run_until",
          [](machine::Network& network, std::int64_t limit) {
            const machine::NetworkStop stop = interruptible([&] { return network.run_until(Time{limit}); });
            return std::pair{std::string(machine::name(stop.reason)), stop.time.count()};
          },
          py::arg("limit"))
      .def_property_readonly("now", [](const machine::Network& network) { return network.now().count(); })
      .def(
          "schedule",
          [](machine::Network& network, const std::string& kind, std::int64_t time, std::size_t target) {
            network.schedule({.kind = machine::action_named(kind), .time = Time{time}, .target = target});
          },
          py::arg("kind"), py::arg("time"), py::arg("target"))
      .def(
          "schedule_pulses",
          [](machine::Network& network, std::int64_t time, std::size_t target, double width_us,
             std::optional<double> period_us, std::optional<std::uint64_t> count) {
            NetworkAction action{.kind = NetworkAction::Kind::pulse, .time = Time{time}, .target = target};
            machine::set_pulses(action, width_us, period_us, count);
            network.schedule(action);
          },
          py::arg("time"), py::arg("target"), py::arg("width_us"), py::arg("period_us"), py::arg("count"))
      .def("net_named",
           [](const machine::Network& network, const std::string& name) {
             return machine::action_target_named(NetworkAction::Kind::low, name, network.description());
           })
      .def_property_readonly("net_count", &machine::Network::net_count)
      .def("net",
           [](const machine::Network& network, std::size_t n) {
             const machine::Net& net = network.net(n);
             return py::dict(py::arg("name") = net.description().name, py::arg("pins") = to_text(net.description()),
                             py::arg("level") = net.level(), py::arg("edges") = net.edges(),
                             py::arg("missed") = net.missed());
           })
      .def("record_words", &machine::Network::record_words, py::arg("on"))
      .def_property_readonly("chip_count", &machine::Network::chip_count)
      .def_property_readonly("memory_count", &machine::Network::memory_count)
      .def_property_readonly("link_count", &machine::Network::link_count)
      .def("chip", [](const std::shared_ptr<machine::Network>& network, std::size_t n) { return ChipOf{network, n}; })
      .def("link", &link_of)
      .def("memory_words",
           [](machine::Network& network, std::size_t n) {
             const auto words = network.memory(n);
             return std::vector<c40::Word>(words.begin(), words.end());
           })
      .def("set_memory_words",
           [](machine::Network& network, std::size_t n, std::size_t at, const std::vector<c40::Word>& words) {
             const auto all = network.memory(n);
             if (at > all.size() || words.size() > all.size() - at) throw py::index_error("the memory ends before");
             std::copy(words.begin(), words.end(), all.begin() + static_cast<std::ptrdiff_t>(at));
             network.changed_by_hand();
           })
      .def("events", [](const machine::Network& network) {
        py::list out;
        for (const machine::NetworkEvent& e : network.events()) {
          out.append(py::dict(py::arg("kind") = std::string(machine::name(e.kind)), py::arg("time_ps") = e.time.count(),
                              py::arg("place") = e.place, py::arg("side") = e.side, py::arg("word") = e.word,
                              py::arg("count") = e.count, py::arg("text") = network.text(e)));
        }
        return out;
      });
}
