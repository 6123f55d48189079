// What a dock records: events, containers, hand-overs, signals.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <string>

#include "plant/dock/dock.hpp"
#include "python/bindings/plant/dock_event.hpp"
#include "python/bindings/plant/plant.hpp"

using namespace plant;

namespace {

std::string to_text(const DockEvent& e) {
  std::string text =
      fmt::format("Event({:.6f} s, {}", static_cast<double>(e.event.time.count()) * 1e-12, name(e.event.kind));
  for (const std::string& part : {object_of(e.event, e.crane), values_of(e.event)})
    if (!part.empty()) text += ", " + part;
  return text + ")";
}

}  // namespace

void bind_plant_records(py::module_& m) {
  py::class_<DockEvent>(m, "Event")
      .def_property_readonly("time", [](const DockEvent& e) { return e.event.time.count(); })
      .def_property_readonly("kind", [](const DockEvent& e) { return name(e.event.kind); })
      .def_property_readonly("index", [](const DockEvent& e) { return e.event.index; })
      .def_property_readonly("values", [](const DockEvent& e) { return e.event.values; })
      .def_property_readonly("object", [](const DockEvent& e) { return object_of(e.event, e.crane); })
      .def("__repr__", &to_text);
  py::class_<ContainerStatus>(m, "ContainerStatus")
      .def_property_readonly("state",
                             [](const ContainerStatus& c) {
                               static constexpr std::array names{"on_ship", "carried", "on_agv", "on_ground",
                                                                 "delivered"};
                               return std::string(names.at(static_cast<std::size_t>(c.state)));
                             })
      .def_readonly("agv", &ContainerStatus::agv)
      .def_readonly("x", &ContainerStatus::x)
      .def_readonly("y", &ContainerStatus::y)
      .def_readonly("z", &ContainerStatus::z)
      .def_readonly("yaw", &ContainerStatus::yaw)
      .def_readonly("up", &ContainerStatus::up)
      .def_readonly("mass", &ContainerStatus::mass);
  py::class_<Handover>(m, "Handover", "The progress of a container's hand-over (plant-and-bus.md 1.5).")
      .def_property_readonly("phase", [](const Handover& h) { return std::string(name(h.phase)); })
      .def_readonly("releasing", &Handover::releasing)
      .def_readonly("attempts", &Handover::attempts);
  py::class_<Momentum>(
      m, "Momentum",
      "Of the payload (3), kg m/s, its spin, kg m2/s; of everything along the quay and about the slewing axis.")
      .def_readonly("payload", &Momentum::payload)
      .def_readonly("spin", &Momentum::spin)
      .def_readonly("travel", &Momentum::travel)
      .def_readonly("slewing", &Momentum::slewing);
  py::class_<PayloadChange>(m, "Switch",
                            "Energy and momentum before and after a change of the payload's model or mass.")
      .def_property_readonly("time", [](const PayloadChange& s) { return s.time.count(); })
      .def_property_readonly("kind", [](const PayloadChange& s) { return std::string(name(s.kind)); })
      .def_readonly("container", &PayloadChange::container)
      .def_readonly("energy_before", &PayloadChange::energy_before)
      .def_readonly("energy_after", &PayloadChange::energy_after)
      .def_readonly("before", &PayloadChange::before)
      .def_readonly("after", &PayloadChange::after);
  py::class_<AgvSignal>(m, "AgvSignal")
      .def_readonly("x", &AgvSignal::x)
      .def_readonly("y", &AgvSignal::y)
      .def_readonly("heading", &AgvSignal::heading)
      .def_readonly("speed", &AgvSignal::speed)
      .def_readonly("yaw_rate", &AgvSignal::yaw_rate)
      .def_readonly("front", &AgvSignal::front)
      .def_readonly("rear", &AgvSignal::rear)
      .def_readonly("speed_command", &AgvSignal::speed_command);
  py::class_<Signal>(m, "Signal")
      .def_property_readonly("time", [](const Signal& s) { return s.time.count(); })
      .def_readonly("q", &Signal::q)
      .def_readonly("qd", &Signal::qd)
      .def_readonly("torque", &Signal::torque)
      .def_readonly("code", &Signal::code)
      .def_readonly("alpha", &Signal::alpha)
      .def_readonly("beta", &Signal::beta)
      .def_readonly("tip", &Signal::tip)
      .def_readonly("payload", &Signal::payload)
      .def_readonly("yaw", &Signal::yaw)
      .def_readonly("tension", &Signal::tension)
      .def_readonly("contact", &Signal::contact);
}
