#pragma once
// Devices written in Python behind windows of a board, and Python's view of the other devices (cmrc/devices.py).
#include <pybind11/stl.h>

#include <string>
#include <vector>

#include "machine/boards/board_devices.hpp"
#include "machine/boards/host_script.hpp"
#include "python/bindings/bindings.hpp"
#include "state/archive.hpp"

/// Calls a cmrc.devices.Attached. Its exceptions go to the caller that runs the chip.
///
/// The object in Python that runs the chip keeps the device alive, and this one refers to it weakly: Python's garbage
/// collector then finds a device that knows its processor or network.
class PythonDevice final : public machine::BoardDevice {
 public:
  explicit PythonDevice(const py::object& attached)
      : reference_(py::weakref(attached)), acts_(attached.attr("acts_on_others").cast<bool>()) {}
  ~PythonDevice() override {
    const py::gil_scoped_acquire gil;
    reference_ = py::object();
  }
  c40::Word read(c40::Address offset, c40::Cycles now) override {
    const py::gil_scoped_acquire gil;
    return attached().attr("read")(offset, now).cast<c40::Word>();
  }
  void write(c40::Address offset, c40::Word value, c40::Cycles now) override {
    const py::gil_scoped_acquire gil;
    attached().attr("write")(offset, value, now);
  }
  void advance_to(c40::Cycles now) override {
    const py::gil_scoped_acquire gil;
    attached().attr("advance_to")(now);
  }
  c40::Cycles next_event() const override {
    const py::gil_scoped_acquire gil;
    return attached().attr("next_event")().cast<std::optional<c40::Cycles>>().value_or(machine::never_cycle);
  }
  bool continues() const override { return true; }
  bool interrupts() const override {
    const py::gil_scoped_acquire gil;
    return attached().attr("interrupts")().cast<bool>();
  }
  bool acts_on_others() const override { return acts_; }
  std::optional<std::string> stateless() const override {
    const py::gil_scoped_acquire gil;
    if (attached().attr("has_state").cast<bool>()) return std::nullopt;
    return "is Python's, and its state is not saved; one with save() and load() has snapshots";
  }
  void list_state(state::Visitor& list) override {
    const py::gil_scoped_acquire gil;
    std::string bytes;
    if (!list.loads()) bytes = attached().attr("save")().cast<std::string>();
    list("state", bytes);
    if (!list.loads()) return;
    const auto* loader = dynamic_cast<const state::Loader*>(&list);
    try {
      attached().attr("load")(py::bytes(bytes));
    } catch (const py::error_already_set&) {
      if (loader == nullptr || !loader->puts_back()) throw;
    }
  }

  /// The device at its place.
  static machine::BoardDevices::Place place(const py::object& attached) {
    machine::DeviceDescription described;
    described.kind = machine::DeviceKind::own;
    described.name = attached.attr("name").cast<std::string>();
    described.base = attached.attr("base").cast<c40::Address>();
    described.words = attached.attr("words").cast<c40::Address>();
    described.waits = attached.attr("waits").cast<int>();
    if (const auto pin = attached.attr("pin").cast<std::optional<std::string>>())
      described.pin = machine::interrupt_pin_named(*pin);
    return {described, std::make_shared<PythonDevice>(attached)};
  }

 private:
  py::object attached() const {
    py::object found = reference_();
    if (found.is_none()) throw std::runtime_error("a device is called whose processor or network is gone");
    return found;
  }

  py::object reference_;  // py::weakref
  bool acts_;
};

/// console, led_changes, led_change_count, not_modelled, type, send and sent of what has devices.
/// \param devices_of may give null: there are none
/// \param now_of the cycle in which its user types or sends
template <class Class, class DevicesOf, class NowOf>
void bind_devices(Class& bound, DevicesOf devices_of, NowOf now_of) {
  using T = typename Class::type;
  const auto all = [devices_of](T& object) -> machine::BoardDevices& {
    static machine::BoardDevices none;
    machine::BoardDevices* devices = devices_of(object);
    return devices == nullptr ? none : *devices;
  };
  const auto add = [all, now_of](T& object, const std::string& name, const std::vector<machine::HostStep>& steps) {
    machine::HostScript* host = all(object).named(name).device->host();
    if (host == nullptr) throw py::value_error("the device " + name + " takes no words from a host");
    host->add(steps, now_of(object));
  };
  bound
      .def(
          "type",
          [all, now_of](T& object, const std::string& text) {
            all(object).type(machine::characters(text), now_of(object));
          },
          py::arg("text"), "Characters for the board's console to read.")
      .def_property_readonly(
          "console", [all](T& object) { return py::bytes(all(object).console()); }, "What the consoles have sent.")
      .def_property_readonly(
          "led_changes",
          [all](T& object) {
            py::list changes;
            for (const auto& change : all(object).changes())
              changes.append(py::make_tuple(change.device, change.cycle, change.value));
            return changes;
          },
          "(name, cycle, value) of the first thousand changes of LEDs.")
      .def_property_readonly(
          "led_change_count", [all](T& object) { return all(object).change_count(); },
          "How many changes of LEDs there were.")
      .def_property_readonly(
          "not_modelled",
          [all](T& object) {
            py::list requests;
            for (const auto& [described, device] : all(object).places())
              for (const auto& request : device->not_modelled())
                requests.append(py::make_tuple(described.name, request.cycle, std::string(request.what)));
            return requests;
          },
          "(name, cycle, what) of what programs asked of devices that these do not do.")
      .def(
          "send",
          [add](T& object, const std::string& name, const std::vector<c40::Word>& words) {
            if (words.empty()) return;
            add(object, name, {machine::HostStep{.when = machine::HostStep::When::at, .number = 0, .words = words}});
          },
          py::arg("name"), py::arg("words"))
      .def(
          "send_script",
          [add](T& object, const std::string& name, const std::string& script) {
            add(object, name, machine::parse_host_script(script, "script"));
          },
          py::arg("name"), py::arg("script"))
      .def(
          "sent",
          [all](T& object, const std::string& name) {
            const std::vector<c40::Word>* sent = all(object).named(name).device->sent();
            if (sent == nullptr) throw py::value_error("the device " + name + " sends no words to a host");
            return *sent;
          },
          py::arg("name"));
}
