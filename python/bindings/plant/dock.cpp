// The dock with its devices.
#include <pybind11/stl.h>

#include "plant/dock/dock.hpp"
#include "plant/dock/state.hpp"
#include "python/bindings/interpreter/ctrl_c.hpp"
#include "python/bindings/interpreter/state.hpp"
#include "python/bindings/plant/dock_event.hpp"
#include "python/bindings/plant/plant.hpp"

using namespace plant;

namespace {

Time ps(std::int64_t t) { return Time{t}; }

// Every call of a device has the instant of the access as its last argument, here "t", integer picoseconds.
const py::arg at("t");

void bind_crane_devices(py::class_<Dock>& dock) {
  dock.def(
          "set_torque_code",
          [](Dock& d, int joint, int code, std::int64_t t) { d.set_torque_code(joint, code, ps(t)); }, py::arg("joint"),
          py::arg("code"), at, "-2048 to 2047 (clamped); 2047 is 1.5 times the rated torque")
      .def(
          "enable_drives", [](Dock& d, std::uint32_t mask, std::int64_t t) { d.enable_drives(mask, ps(t)); },
          py::arg("mask"), at, "bit j for joint j; a disabled drive has no torque and its brake holds")
      .def(
          "encoder", [](Dock& d, int joint, std::int64_t t) { return d.encoder(joint, ps(t)); }, py::arg("joint"), at,
          "24 bits")
      .def(
          "encoder_total", [](Dock& d, int joint, std::int64_t t) { return d.encoder_total(joint, ps(t)); },
          py::arg("joint"), at, "the same count since joint zero, not wrapped")
      .def(
          "sway", [](Dock& d, int axis, std::int64_t t) { return d.sway(axis, ps(t)); }, py::arg("axis"), at,
          "0 radial, 1 tangential; 2048 is 10 degrees")
      .def(
          "spreader_command",
          [](Dock& d, std::uint32_t command, std::int64_t t) { d.spreader_command(command, ps(t)); },
          py::arg("command"), at, "1 locks, 0 opens")
      .def(
          "spreader_status", [](Dock& d, std::int64_t t) { return d.spreader_status(ps(t)); }, at,
          "bits 3..0 corners, 4 locked, 5 open")
      .def(
          "fail_drive", [](Dock& d, int joint, bool failed, std::int64_t t) { d.fail_drive(joint, failed, ps(t)); },
          py::arg("joint"), py::arg("failed"), at, "a failed drive has no torque and its brake holds")
      .def(
          "fail_encoder", [](Dock& d, int joint, bool failed, std::int64_t t) { d.fail_encoder(joint, failed, ps(t)); },
          py::arg("joint"), py::arg("failed"), at, "a failed sensor keeps its present value")
      .def(
          "fail_sway", [](Dock& d, int axis, bool failed, std::int64_t t) { d.fail_sway(axis, failed, ps(t)); },
          py::arg("axis"), py::arg("failed"), at, "a failed sensor keeps its present value");
}

void bind_instruments(py::class_<Dock>& dock) {
  dock.def(
          "drive_status", [](Dock& d, int joint, std::int64_t t) { return d.drive_status(joint, ps(t)); },
          py::arg("joint"), at, "bits: 0 ready, 1 fault, 2 timed out, 3 brake closed")
      .def(
          "drive_speed", [](Dock& d, int joint, std::int64_t t) { return d.drive_speed(joint, ps(t)); },
          py::arg("joint"), at, "the drive's own estimate of its motor's speed; 10000 is rated")
      .def(
          "drive_trip", [](Dock& d, int joint, std::int64_t t) { return d.drive_trip(joint, ps(t)); }, py::arg("joint"),
          at,
          "why it tripped last, until it is switched on again: bits 0 too fast, 1 too long at its largest code, 2 too "
          "hot; bit 3 warning of its heat")
      .def(
          "drive_heat", [](Dock& d, int joint, std::int64_t t) { return d.drive_heat(joint, ps(t)); }, py::arg("joint"),
          at, "its thermal model; 10000 is what the rated torque comes to")
      .def(
          "load_cell", [](Dock& d, std::int64_t t) { return d.load_cell(ps(t)); }, at, "kg on the rope, in steps of 10")
      .def(
          "second_sway", [](Dock& d, int axis, std::int64_t t) { return d.second_sway(axis, ps(t)); }, py::arg("axis"),
          at, "as sway, of the second sensor")
      .def(
          "wind_mean", [](Dock& d, std::int64_t t) { return d.wind_mean(ps(t)); }, at,
          "anemometer, mm/s: mean of the last 3 s")
      .def(
          "fail_drive_status",
          [](Dock& d, int joint, bool failed, std::int64_t t) { d.fail_drive_status(joint, failed, ps(t)); },
          py::arg("joint"), py::arg("failed"), at, "a failed device keeps its present value")
      .def(
          "fail_drive_speed",
          [](Dock& d, int joint, bool failed, std::int64_t t) { d.fail_drive_speed(joint, failed, ps(t)); },
          py::arg("joint"), py::arg("failed"), at, "a failed device keeps its present value")
      .def(
          "fail_load_cell", [](Dock& d, bool failed, std::int64_t t) { d.fail_load_cell(failed, ps(t)); },
          py::arg("failed"), at, "a failed device keeps its present value")
      .def(
          "fail_second_sway",
          [](Dock& d, int axis, bool failed, std::int64_t t) { d.fail_second_sway(axis, failed, ps(t)); },
          py::arg("axis"), py::arg("failed"), at, "a failed device keeps its present value")
      .def(
          "fail_anemometer", [](Dock& d, bool failed, std::int64_t t) { d.fail_anemometer(failed, ps(t)); },
          py::arg("failed"), at, "a failed device keeps its present value");
}

void bind_scanner(py::class_<Dock>& dock) {
  dock.def("scan_rows", &Dock::scan_rows, "how many rows the bay has")
      .def(
          "select_row", [](Dock& d, std::int32_t row, std::int64_t t) { d.select_row(row, ps(t)); }, py::arg("row"), at)
      .def(
          "scan_y", [](Dock& d, std::int64_t t) { return d.scan_y(ps(t)); }, at, "of the selected row, mm")
      .def("scan_x0", &Dock::scan_x0, "mm")
      .def("scan_dx", &Dock::scan_dx, "mm")
      .def("scan_deck", &Dock::scan_deck, "mm")
      .def(
          "profile", [](Dock& d, int i, std::int64_t t) { return d.profile(i, ps(t)); }, py::arg("i"), at,
          "0..127: mean height of a cell of the selected row, mm in steps of 8");
}

void bind_agv_units(py::class_<Dock>& dock) {
  dock.def_property_readonly("agv_count", &Dock::agv_count)
      .def(
          "agv_x", [](Dock& d, int agv, std::int64_t t) { return d.agv_x(agv, ps(t)); }, py::arg("agv"), at, "mm")
      .def(
          "agv_y", [](Dock& d, int agv, std::int64_t t) { return d.agv_y(agv, ps(t)); }, py::arg("agv"), at, "mm")
      .def(
          "agv_heading", [](Dock& d, int agv, std::int64_t t) { return d.agv_heading(agv, ps(t)); }, py::arg("agv"), at,
          "microradians")
      .def(
          "agv_speed", [](Dock& d, int agv, std::int64_t t) { return d.agv_speed(agv, ps(t)); }, py::arg("agv"), at,
          "mm/s")
      .def(
          "agv_status", [](Dock& d, int agv, std::int64_t t) { return d.agv_status(agv, ps(t)); }, py::arg("agv"), at,
          "bits 3..0 set-points waiting, 4 standing, 5 loaded, 6 ran dry while driving, 7 bumper")
      .def(
          "agv_range", [](Dock& d, int agv, int ray, std::int64_t t) { return d.agv_range(agv, ray, ps(t)); },
          py::arg("agv"), py::arg("ray"), at, "mm in steps of 8; 30000: nothing within it; 0: no valid echo")
      .def(
          "agv_scan",
          [](Dock& d, int agv, std::int64_t t) {
            std::vector<std::int32_t> rays(range_rays);
            for (int ray = 0; ray < range_rays; ++ray)
              rays[static_cast<std::size_t>(ray)] = d.agv_range(agv, ray, ps(t));
            return rays;
          },
          py::arg("agv"), at, "agv_range of every ray, from the right to the left")
      .def(
          "range_way", [](Dock& d, int agv, std::int64_t t) { return d.range_way(agv, ps(t)); }, py::arg("agv"), at,
          "mm from the vehicle's front to the nearest echo in its way; 30000: none.")
      .def(
          "range_scan", [](Dock& d, int agv, std::int64_t t) { return d.range_scan(agv, ps(t)); }, py::arg("agv"), at,
          "number of the scan that agv_range shows")
      .def_property_readonly("range_mount", &Dock::range_mount, "mm ahead of the vehicle's centre")
      .def(
          "agv_period", [](Dock& d, int agv, std::uint32_t us, std::int64_t t) { d.agv_period(agv, us, ps(t)); },
          py::arg("agv"), py::arg("microseconds"), at, "each set-point is held for so long")
      .def(
          "agv_push",
          [](Dock& d, int agv, std::int32_t speed, std::int32_t front, std::int32_t rear, std::int64_t t) {
            d.agv_push(agv, speed, front, rear, ps(t));
          },
          py::arg("agv"), py::arg("speed"), py::arg("front"), py::arg("rear"), at, "a set-point: mm/s, microradians")
      .def(
          "agv_push_wheels",
          [](Dock& d, int agv, std::int32_t left, std::int32_t right, std::int64_t t) {
            d.agv_push_wheels(agv, left, right, ps(t));
          },
          py::arg("agv"), py::arg("left"), py::arg("right"), at, "mm/s, differential drive only")
      .def(
          "agv_reset_bumper", [](Dock& d, int agv, std::int64_t t) { d.agv_reset_bumper(agv, ps(t)); }, py::arg("agv"),
          at, "after a collision");
}

void bind_observers(py::class_<Dock>& dock) {
  constexpr auto copy = py::return_value_policy::copy;
  dock.def_property_readonly("events", &events_of)
      .def_property_readonly("containers", &Dock::containers)
      .def("agv", &Dock::agv, py::arg("agv"), "true pose and speed at the last latch")
      .def_property_readonly("signal", &Dock::signal)
      .def_property_readonly("signals", &Dock::signals, copy)
      .def_property_readonly("agv_signals", &Dock::agv_signals, copy)
      .def_property_readonly("delivered", &Dock::delivered)
      .def_property_readonly("handover", &Dock::handover)
      .def_property_readonly("switches", &Dock::switches, copy)
      .def_property_readonly("faulted", &Dock::faulted)
      .def_property_readonly("payload_mass", &Dock::payload_mass)
      .def_property_readonly("energy", &Dock::energy);
}

void bind_dock(py::module_& m) {
  py::class_<Dock> dock(m, "Dock", "The dock in time; t is integer picoseconds, nondecreasing over calls.");
  dock.def(py::init<const DockConfig&>(), py::arg("config"))
      .def(
          "advance_to",
          [](Dock& d, std::int64_t t) {
            constexpr std::int64_t slice = 100'000'000'000;  // 0.1 s; then Ctrl-C is heard
            interruptible([&] {                              // with the GIL: nothing else keeps other threads out
              while (d.time().count() + slice < t && !io::stop_asked()) d.advance_to(ps(d.time().count() + slice));
              if (!io::stop_asked()) d.advance_to(ps(t));
            });
          },
          at)
      .def_property_readonly("time", [](const Dock& d) { return d.time().count(); })
      .def_property_readonly("config", &Dock::config)
      .def("snapshot", [](const Dock& d) { return std::make_shared<DockState>(*d.snapshot()); })
      .def("restore", &Dock::restore, py::arg("state"))
      .def("state_hash", &Dock::state_hash);
  bind_state<Dock>(dock);
  bind_crane_devices(dock);
  bind_instruments(dock);
  bind_scanner(dock);
  bind_agv_units(dock);
  bind_observers(dock);
}

}  // namespace

void bind_plant_dock(py::module_& m) {
  bind_plant_state(m);
  bind_dock(m);
}
