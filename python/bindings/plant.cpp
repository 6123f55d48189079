#include <pybind11/native_enum.h>
#include <pybind11/stl.h>

#include <cmath>

#include "plant/agv_alone.hpp"
#include "plant/contact.hpp"
#include "plant/crane.hpp"
#include "plant/crane_alone.hpp"
#include "plant/dock.hpp"
#include "plant/layout_file.hpp"
#include "plant/linkage.hpp"
#include "plant/motion.hpp"
#include "plant/ode_crane.hpp"
#include "plant/state.hpp"
#include "plant/wind.hpp"
#include "python/bindings/bindings.hpp"

using namespace plant;

namespace {

void bind_crane_parameters(py::module_& m) {
  py::class_<DriveParameters>(m, "DriveParameters", "One joint's drive; torques on the motor side, N m.")
      .def_readwrite("rated_torque", &DriveParameters::rated_torque)
      .def_readwrite("rated_speed", &DriveParameters::rated_speed)
      .def_readwrite("gear", &DriveParameters::gear)
      .def_readwrite("rotor_inertia", &DriveParameters::rotor_inertia)
      .def_readwrite("efficiency", &DriveParameters::efficiency)
      .def_readwrite("torque_lag", &DriveParameters::torque_lag)
      .def_readwrite("coulomb", &DriveParameters::coulomb)
      .def_readwrite("stribeck", &DriveParameters::stribeck)
      .def_readwrite("viscous", &DriveParameters::viscous)
      .def_readwrite("smooth_speed", &DriveParameters::smooth_speed)
      .def_readwrite("stribeck_speed", &DriveParameters::stribeck_speed)
      .def_readwrite("brake", &DriveParameters::brake)
      .def_property_readonly("maximum_torque", &DriveParameters::maximum_torque)
      .def_property_readonly("rated_force", &DriveParameters::rated_force)
      .def_property_readonly("rated_joint_speed", &DriveParameters::rated_joint_speed);
  py::native_enum<Machine>(m, "Machine", "enum.Enum").value("slewing", Machine::slewing).value("gantry", Machine::gantry).finalize();
  m.def("gantry_crane", &gantry_crane, "parameters of a ship-to-shore gantry");
  py::class_<CraneParameters>(m, "CraneParameters", "Geometry (m), masses (kg, kg m2), limits and drives of a crane (plant-and-bus.md 1.4, docs/plant.md).")
      .def(py::init<>())
      .def_readwrite("machine", &CraneParameters::machine)
      .def_readwrite("a0", &CraneParameters::a0)
      .def_readwrite("jib", &CraneParameters::jib)
      .def_readwrite("pivot_height", &CraneParameters::pivot_height)
      .def_readwrite("gantry_mass", &CraneParameters::gantry_mass)
      .def_readwrite("slew_inertia", &CraneParameters::slew_inertia)
      .def_readwrite("jib_mass", &CraneParameters::jib_mass)
      .def_readwrite("jib_centre", &CraneParameters::jib_centre)
      .def_readwrite("jib_inertia", &CraneParameters::jib_inertia)
      .def_readwrite("counterweight", &CraneParameters::counterweight)
      .def_readwrite("counterweight_radius", &CraneParameters::counterweight_radius)
      .def_readwrite("spreader_mass", &CraneParameters::spreader_mass)
      .def_readwrite("spreader_inertia", &CraneParameters::spreader_inertia)
      .def_readwrite("sway_damping", &CraneParameters::sway_damping)
      .def_readwrite("gear_losses", &CraneParameters::gear_losses)
      .def_readwrite("stiction", &CraneParameters::stiction)
      .def_readwrite("lower", &CraneParameters::lower)
      .def_readwrite("upper", &CraneParameters::upper)
      .def_property(
          "drives", [](CraneParameters& p) { return std::vector<DriveParameters>(p.drives.begin(), p.drives.end()); },
          [](CraneParameters& p, const std::array<DriveParameters, joint_count>& drives) { p.drives = drives; });
  py::class_<CranePose>(m, "CranePose", "Gantry s and the middle of the spreader's underside x, y, z, m; its yaw, rad.")
      .def(py::init<double, double, double, double, double>(), py::arg("s"), py::arg("x"), py::arg("y"), py::arg("z"),
           py::arg("yaw"))
      .def_readwrite("s", &CranePose::s)
      .def_readwrite("x", &CranePose::x)
      .def_readwrite("y", &CranePose::y)
      .def_readwrite("z", &CranePose::z)
      .def_readwrite("yaw", &CranePose::yaw);
}

void bind_motion(py::module_& m) {
  py::class_<Crane>(m, "Crane", "The crane's equations in closed form; q = (s, psi, phi, l, alpha, beta, kappa), SI units.")
      .def(py::init<const CraneParameters&>())
      .def("mass_matrix",
           [](const Crane& c, const CraneVector& q, double mass, double inertia) { return c.mass_matrix(q, {mass, inertia}); },
           py::arg("q"), py::arg("mass"), py::arg("inertia"))
      .def("bias",
           [](const Crane& c, const CraneVector& q, const CraneVector& qd, double mass, double inertia) {
             return c.bias(q, qd, {mass, inertia});
           },
           py::arg("q"), py::arg("qd"), py::arg("mass"), py::arg("inertia"))
      .def("gravity",
           [](const Crane& c, const CraneVector& q, double mass) { return c.gravity_force(q, {mass, 0.0}); }, py::arg("q"),
           py::arg("mass"))
      .def("acceleration",
           [](const Crane& c, const CraneVector& q, const CraneVector& qd, const CraneVector& force, double mass,
              double inertia, unsigned locked) { return c.acceleration(q, qd, force, {mass, inertia}, locked); },
           py::arg("q"), py::arg("qd"), py::arg("force"), py::arg("mass"), py::arg("inertia"), py::arg("locked") = 0U,
           "qdd under generalised forces; locked: bit k holds coordinate k at rest")
      .def("kinetic_energy",
           [](const Crane& c, const CraneVector& q, const CraneVector& qd, double mass, double inertia) {
             return c.kinetic_energy(q, qd, {mass, inertia});
           },
           py::arg("q"), py::arg("qd"), py::arg("mass"), py::arg("inertia"))
      .def("potential_energy",
           [](const Crane& c, const CraneVector& q, double mass) { return c.potential_energy(q, {mass, 0.0}); }, py::arg("q"),
           py::arg("mass"))
      .def("friction", &Crane::friction, py::arg("joint"), py::arg("speed"), py::arg("sliding") = 0)
      .def("static_friction", &Crane::static_friction, py::arg("joint"))
      .def("tip", &Crane::tip, py::arg("q"))
      .def("payload_position", &Crane::payload_position, py::arg("q"))
      .def("tip_velocity", &Crane::tip_velocity, py::arg("q"), py::arg("qd"))
      .def("payload_velocity", &Crane::payload_velocity, py::arg("q"), py::arg("qd"));
  m.def("inverse_kinematics", &inverse_kinematics, py::arg("crane"), py::arg("pose"));

  py::class_<CraneState>(m, "CraneState")
      .def(py::init<>())
      .def_readwrite("q", &CraneState::q)
      .def_readwrite("qd", &CraneState::qd)
      .def_readwrite("torque", &CraneState::torque)
      .def_readwrite("step", &CraneState::step);
  py::class_<CraneInputs>(m, "CraneInputs")
      .def(py::init<>())
      .def_readwrite("command", &CraneInputs::command)
      .def_readwrite("braked", &CraneInputs::braked)
      .def_readwrite("locked", &CraneInputs::locked)
      .def_readwrite("external", &CraneInputs::external)
      .def_property(
          "payload", [](const CraneInputs& i) { return std::pair{i.payload.mass, i.payload.inertia}; },
          [](CraneInputs& i, std::pair<double, double> p) { i.payload = {p.first, p.second}; });
  py::class_<Work>(m, "Work", "Where energy went, J.")
      .def_readonly("motors", &Work::motors)
      .def_readonly("gears", &Work::gears)
      .def_readonly("friction", &Work::friction)
      .def_readonly("damping", &Work::damping)
      .def_readonly("external", &Work::external)
      .def_readonly("impacts", &Work::impacts)
      .def_property_readonly("stored", &Work::stored);
  py::native_enum<Method>(m, "Method", "enum.Enum").value("erk", Method::erk).value("adams", Method::adams).value("bdf", Method::bdf).finalize();
  py::class_<CraneMotion>(m, "CraneMotion", "The crane with drives and friction, integrated by SUNDIALS.")
      .def(py::init([](const CraneParameters& crane, double tolerance, int order, Method method) {
             return std::make_unique<CraneMotion>(crane, Integrator::Settings{method, order, tolerance});
           }),
           py::arg("crane"), py::arg("tolerance") = 1e-8, py::arg("order") = 4, py::arg("method") = Method::erk)
      .def("advance", &CraneMotion::advance, py::arg("state"), py::arg("inputs"), py::arg("seconds"))
      .def("advance_fixed", &CraneMotion::advance_fixed, py::arg("state"), py::arg("inputs"), py::arg("seconds"), py::arg("step"))
      .def("advance_booked", &CraneMotion::advance_booked, py::arg("state"), py::arg("inputs"), py::arg("seconds"))
      .def("acceleration", &CraneMotion::acceleration, py::arg("state"), py::arg("inputs"))
      .def("holding_force", &CraneMotion::holding_force, py::arg("state"), py::arg("inputs"));
}

#define FIELD(T, name) .def_readwrite(#name, &T::name)

void bind_config(py::module_& m) {
  py::class_<LandingParameters>(m, "LandingParameters", "The payload near contact (level L2) and the landing: N, N/m, N s/m, m, rad, s (plant-and-bus.md 1.3, 1.5).")
      .def(py::init<>())
      FIELD(LandingParameters, fall_stiffness) FIELD(LandingParameters, fall_damping)
      FIELD(LandingParameters, fall_spread_x) FIELD(LandingParameters, fall_spread_y)
      FIELD(LandingParameters, yaw_stiffness) FIELD(LandingParameters, yaw_damping)
      FIELD(LandingParameters, corner_stiffness) FIELD(LandingParameters, corner_damping)
      FIELD(LandingParameters, friction) FIELD(LandingParameters, near) FIELD(LandingParameters, away)
      FIELD(LandingParameters, guides) FIELD(LandingParameters, guide_window) FIELD(LandingParameters, guide_height)
      FIELD(LandingParameters, guide_stiffness) FIELD(LandingParameters, guide_damping)
      FIELD(LandingParameters, seat_error) FIELD(LandingParameters, seat_gap) FIELD(LandingParameters, touch_speed)
      FIELD(LandingParameters, touch_sway) FIELD(LandingParameters, lock_time)
      FIELD(LandingParameters, strict) FIELD(LandingParameters, yaw_error);
  py::native_enum<AgvDrive>(m, "AgvDrive", "enum.Enum")
      .value("steered", AgvDrive::steered)
      .value("differential", AgvDrive::differential)
      .finalize();
  py::class_<AgvParameters>(m, "AgvParameters", "A container transporter: kg, m, kg m2, N/rad, rad, s, m/s2 (plant-and-bus.md 1.4, 1.5).")
      .def(py::init<>())
      FIELD(AgvParameters, mass) FIELD(AgvParameters, length) FIELD(AgvParameters, width) FIELD(AgvParameters, front)
      FIELD(AgvParameters, rear) FIELD(AgvParameters, yaw_inertia) FIELD(AgvParameters, deck_height)
      FIELD(AgvParameters, cornering) FIELD(AgvParameters, adhesion) FIELD(AgvParameters, rolling)
      FIELD(AgvParameters, drag) FIELD(AgvParameters, steer_limit) FIELD(AgvParameters, steer_rate)
      FIELD(AgvParameters, steer_lag) FIELD(AgvParameters, drive_lag) FIELD(AgvParameters, acceleration)
      FIELD(AgvParameters, braking) FIELD(AgvParameters, emergency) FIELD(AgvParameters, blend_speed)
      FIELD(AgvParameters, speed_gain) FIELD(AgvParameters, speed_integral) FIELD(AgvParameters, drive) FIELD(AgvParameters, track)
      FIELD(AgvParameters, wheel_slip) FIELD(AgvParameters, protective_field) FIELD(AgvParameters, protective_margin);
  py::class_<SensorParameters>(m, "SensorParameters", "Sway sensor (rad) and range sensors (Hz, probability); seed of their noise (plant-and-bus.md 1.4, 1.5).")
      .def(py::init<>())
      FIELD(SensorParameters, sway_range) FIELD(SensorParameters, sway_noise) FIELD(SensorParameters, seed)
      FIELD(SensorParameters, range_rate) FIELD(SensorParameters, range_dropout);
  py::class_<WindParameters>(m, "WindParameters", "Mean and gusts in m/s, whither in rad, drag area in m2, seed.")
      .def(py::init<>())
      FIELD(WindParameters, mean) FIELD(WindParameters, gust) FIELD(WindParameters, direction)
      FIELD(WindParameters, area) FIELD(WindParameters, seed);
  py::class_<ShipMotion>(m, "ShipMotion", "A moored ship: scale of its motion, m that it rises per kg that leaves it, seed (plant-and-bus.md 1.5).")
      .def(py::init<>())
      FIELD(ShipMotion, scale) FIELD(ShipMotion, draught) FIELD(ShipMotion, seed);
  m.def("wind_speed", &wind_speed, py::arg("wind"), py::arg("seconds"));
  py::class_<Box>(m, "Box", "A box in the world, m.")
      .def(py::init<double, double, double, double, double, double>())
      FIELD(Box, x_min) FIELD(Box, x_max) FIELD(Box, y_min) FIELD(Box, y_max) FIELD(Box, z_min) FIELD(Box, z_max);
  py::class_<Waypoint>(m, "Waypoint", "Where a mover is, m, at a time, s.")
      .def(py::init<double, double, double>(), py::arg("time"), py::arg("x"), py::arg("y"))
      FIELD(Waypoint, time) FIELD(Waypoint, x) FIELD(Waypoint, y);
  py::class_<Mover>(m, "Mover", "An upright cylinder that follows its waypoints; with one of them it stands.")
      .def(py::init<double, double, std::vector<Waypoint>, bool>(), py::arg("radius"), py::arg("height"), py::arg("path"),
           py::arg("repeats") = false)
      FIELD(Mover, radius) FIELD(Mover, height) FIELD(Mover, path) FIELD(Mover, repeats);
  m.def("mover_place", [](const Mover& mover, double seconds) {
    const MoverPlace p = place_of(mover, seconds);
    return std::array{p.x, p.y, p.vx, p.vy};
  }, "x, y and their rates");
  py::class_<ContainerPlace>(m, "ContainerPlace", "Centre of the underside, m; yaw, rad; gross mass, kg.")
      .def(py::init<double, double, double, double, double>(), py::arg("x"), py::arg("y"), py::arg("z"), py::arg("yaw"),
           py::arg("mass"))
      FIELD(ContainerPlace, x) FIELD(ContainerPlace, y) FIELD(ContainerPlace, z) FIELD(ContainerPlace, yaw)
      FIELD(ContainerPlace, mass);
  py::class_<LaneSegment>(m, "LaneSegment", "A line or arc of lane driven forward: from x, y (m) and heading (rad), length m, curvature 1/m (left positive), speed m/s.")
      .def(py::init<double, double, double, double, double, double>(), py::arg("x"), py::arg("y"), py::arg("heading"),
           py::arg("length"), py::arg("curvature"), py::arg("speed"))
      FIELD(LaneSegment, x) FIELD(LaneSegment, y) FIELD(LaneSegment, heading) FIELD(LaneSegment, length)
      FIELD(LaneSegment, curvature) FIELD(LaneSegment, speed);
  py::class_<Pose>(m, "Pose", "m and rad.").def(py::init<double, double, double>(), py::arg("x"), py::arg("y"), py::arg("heading"))
      FIELD(Pose, x) FIELD(Pose, y) FIELD(Pose, heading);
  py::class_<Layout>(m, "Layout", "What stands where on the dock, m and rad (docs/plant.md, A layout of one's own).")
      .def(py::init<>())
      FIELD(Layout, deck) FIELD(Layout, rows) FIELD(Layout, scan_x0) FIELD(Layout, scan_dx) FIELD(Layout, containers)
      FIELD(Layout, ship) FIELD(Layout, no_go) FIELD(Layout, movers) FIELD(Layout, spot) FIELD(Layout, warehouse) FIELD(Layout, warehouse_radius)
      FIELD(Layout, warehouse_take) FIELD(Layout, slot_spacing) FIELD(Layout, legs);
  py::class_<DockConfig>(m, "DockConfig", "A dock's configuration; default_dock() is the one to begin with.")
      .def(py::init<>())
      FIELD(DockConfig, crane) FIELD(DockConfig, landing) FIELD(DockConfig, agv) FIELD(DockConfig, sensors) FIELD(DockConfig, wind) FIELD(DockConfig, ship)
      FIELD(DockConfig, layout) FIELD(DockConfig, agv_count) FIELD(DockConfig, home) FIELD(DockConfig, tolerance)
      FIELD(DockConfig, signal_decimation) FIELD(DockConfig, method) FIELD(DockConfig, rigid) FIELD(DockConfig, collisions) FIELD(DockConfig, rated_load) FIELD(DockConfig, drive_timeout);
  m.def("default_dock", &default_dock, py::arg("agv_count") = 1);
  m.def("gantry_dock", &gantry_dock, py::arg("agv_count") = 1);
  m.def("drive_channels", &drive_channels, py::arg("machine"), "the joint behind each drive channel of the bus");
  py::register_exception<LayoutError>(m, "LayoutError", PyExc_ValueError);
  m.def("apply_layout", &apply_layout, py::arg("config"), py::arg("text"), py::arg("name") = "layout");
  m.def("load_layout", &load_layout, py::arg("config"), py::arg("path"));
}

void bind_alone(py::module_& m) {
  py::class_<CraneAlone::State>(m, "CraneAloneState", "Everything that the crane's future depends on; opaque but for reading.")
      .def_property_readonly("time", [](const CraneAlone::State& s) { return s.time; });
  py::class_<CraneAlone>(m, "CraneAlone", "A crane by itself, driven by motor torques.")
      .def(py::init([](const CraneParameters& crane, const CranePose& home, double mass, double inertia, double rated_load, bool rigid,
                       double tolerance, Method method, int order, bool bookkeeping, const SensorParameters& sensors,
                       const WindParameters& wind) {
             return std::make_unique<CraneAlone>(CraneAloneConfig{
                 crane, home, {mass, inertia}, rated_load, rigid, tolerance, method, order, bookkeeping, sensors, wind});
           }),
           py::arg("crane"), py::arg("home"), py::arg("mass"), py::arg("inertia"), py::arg("rated_load"), py::arg("rigid"),
           py::arg("tolerance"), py::arg("method"), py::arg("order"), py::arg("bookkeeping"), py::arg("sensors"), py::arg("wind"))
      .def("step", &CraneAlone::step, py::arg("torques"), py::arg("dt"))
      .def(
          "run", [](CraneAlone& c, const Joints& torque, double dt, long steps) { for (long i = 0; i < steps; ++i) c.step(torque, dt); },
          py::arg("torques"), py::arg("dt"), py::arg("steps"), py::call_guard<py::gil_scoped_release>())
      .def("set_load", [](CraneAlone& c, double mass, double inertia) { c.set_load({mass, inertia}); }, py::arg("mass"), py::arg("inertia"))
      .def("reset", &CraneAlone::reset, py::arg("q"), py::arg("qd"))
      .def("snapshot", [](const CraneAlone& c) { return c.state(); })
      .def("restore", &CraneAlone::restore)
      .def_property_readonly("q", [](const CraneAlone& c) { return c.state().crane.q; })
      .def_property_readonly("qd", [](const CraneAlone& c) { return c.state().crane.qd; })
      .def_property_readonly("torque", [](const CraneAlone& c) { return c.state().crane.torque; })
      .def_property_readonly("time", [](const CraneAlone& c) { return c.state().time; })
      .def_property_readonly("faulted", [](const CraneAlone& c) { return c.state().faulted; })
      .def_property_readonly("at_limit", [](const CraneAlone& c) { return c.state().modes.at_limit; })
      .def_property_readonly("stuck", [](const CraneAlone& c) { return c.state().modes.stuck; })
      .def_property_readonly("work", [](const CraneAlone& c) { return c.state().work; })
      .def_property_readonly("events",
                             [](const CraneAlone& c) {
                               static constexpr std::array names{"limit", "stuck", "slipped", "slack", "swung_out"};
                               std::vector<std::tuple<std::int64_t, std::string, int>> all;
                               for (const auto& e : c.events()) all.emplace_back(e.time, names.at(static_cast<std::size_t>(e.kind)), e.joint);
                               return all;
                             })
      .def_property_readonly("swung_out", [](const CraneAlone& c) { return c.state().swung_out; })
      .def_property_readonly("payload", [](const CraneAlone& c) { return std::pair{c.state().inputs.payload.mass, c.state().inputs.payload.inertia}; })
      .def_property_readonly("model", [](const CraneAlone& c) { return c.crane(); })
      .def("acceleration", &CraneAlone::acceleration)
      .def("energy", &CraneAlone::energy)
      .def("encoders", &CraneAlone::encoders)
      .def("sway", &CraneAlone::sway)
      .def("sensitivity", [](const CraneAlone& c, const Joints& torque, double seconds) {
        const CraneSensitivity s = c.sensitivity(torque, seconds);
        return std::tuple{s.q_by_mass, s.qd_by_mass, s.q_by_length, s.qd_by_length};
      }, py::arg("torques"), py::arg("seconds"));
}

void bind_agv_alone(py::module_& m) {
  py::class_<AgvAlone::State>(m, "AgvAloneState", "Everything that a vehicle's future depends on; opaque.");
  py::class_<AgvAlone>(m, "AgvAlone", "An AGV without a dock.")
      .def(py::init<const AgvParameters&, const Pose&, double>(), py::arg("parameters"), py::arg("start"), py::arg("tolerance") = 1e-8)
      .def(
          "step", [](AgvAlone& a, double speed, double front, double rear, double turn, double dt) { a.step({speed, front, rear, turn}, dt); },
          py::arg("speed"), py::arg("front"), py::arg("rear"), py::arg("turn"), py::arg("dt"))
      .def("set_load", &AgvAlone::set_load, py::arg("mass"), py::arg("inertia"))
      .def("reset", &AgvAlone::reset, py::arg("pose"))
      .def_property_readonly("y", [](const AgvAlone& a) { return a.state().vehicle.y; })
      .def_property_readonly("standing", [](const AgvAlone& a) { return a.state().vehicle.standing; })
      .def_property_readonly("time", [](const AgvAlone& a) { return a.state().time; })
      .def("snapshot", [](const AgvAlone& a) { return a.state(); })
      .def("restore", &AgvAlone::restore, py::arg("state"))
      .def("energy", &AgvAlone::energy);
}

Time ps(std::int64_t t) { return Time{t}; }

void bind_records(py::module_& m) {
  py::class_<Event>(m, "Event")
      .def_property_readonly("time", [](const Event& e) { return e.time.count(); })
      .def_property_readonly("kind", [](const Event& e) { return std::string(name(e.kind)); })
      .def_readonly("index", &Event::index)
      .def_readonly("values", &Event::values)
      .def("__repr__", [](const Event& e) {
        return std::string(py::str("Event({:.6f} s, {}, {}, {})")
                               .format(static_cast<double>(e.time.count()) * 1e-12, name(e.kind), e.index, e.values));
      });
  py::class_<ContainerStatus>(m, "ContainerStatus")
      .def_property_readonly("state",
                             [](const ContainerStatus& c) {
                               static constexpr std::array names{"on_ship", "carried", "on_agv", "on_ground", "delivered"};
                               return std::string(names.at(static_cast<std::size_t>(c.state)));
                             })
      .def_readonly("agv", &ContainerStatus::agv)
      .def_readonly("x", &ContainerStatus::x)
      .def_readonly("y", &ContainerStatus::y)
      .def_readonly("z", &ContainerStatus::z)
      .def_readonly("yaw", &ContainerStatus::yaw)
      .def_readonly("mass", &ContainerStatus::mass);
  py::class_<Handover>(m, "Handover", "Where a container's change of hands stands (plant-and-bus.md 1.5).")
      .def_property_readonly("phase", [](const Handover& h) { return std::string(name(h.phase)); })
      .def_readonly("releasing", &Handover::releasing)
      .def_readonly("attempts", &Handover::attempts);
  py::class_<Momentum>(m, "Momentum", "Of the payload (3), kg m/s, its spin, kg m2/s; of everything along the quay and about the slewing axis.")
      .def_readonly("payload", &Momentum::payload)
      .def_readonly("spin", &Momentum::spin)
      .def_readonly("travel", &Momentum::travel)
      .def_readonly("slewing", &Momentum::slewing);
  py::class_<Switch>(m, "Switch", "Energy and momentum before and after a change of the payload's model or mass.")
      .def_property_readonly("time", [](const Switch& s) { return s.time.count(); })
      .def_property_readonly("kind", [](const Switch& s) { return std::string(name(s.kind)); })
      .def_readonly("container", &Switch::container)
      .def_readonly("energy_before", &Switch::energy_before)
      .def_readonly("energy_after", &Switch::energy_after)
      .def_readonly("before", &Switch::before)
      .def_readonly("after", &Switch::after);
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
  py::class_<DockState, std::shared_ptr<DockState>>(m, "DockState", "A dock's complete state at a latch; opaque.");
}

void bind_dock(py::module_& m) {
  m.attr("latch_period") = latch_period.count();
  py::class_<Dock>(m, "Dock", "The dock in time; t is integer picoseconds, nondecreasing over calls.")
      .def(py::init<const DockConfig&>(), py::arg("config"))
      .def("advance_to", [](Dock& d, std::int64_t t) { d.advance_to(ps(t)); }, py::call_guard<py::gil_scoped_release>())
      .def_property_readonly("time", [](const Dock& d) { return d.time().count(); })
      .def_property_readonly("config", &Dock::config)
      .def("set_torque_code", [](Dock& d, int j, int code, std::int64_t t) { d.set_torque_code(j, code, ps(t)); })
      .def("enable_drives", [](Dock& d, std::uint32_t mask, std::int64_t t) { d.enable_drives(mask, ps(t)); })
      .def("fail_drive", [](Dock& d, int j, bool failed, std::int64_t t) { d.fail_drive(j, failed, ps(t)); })
      .def("fail_encoder", [](Dock& d, int j, bool failed, std::int64_t t) { d.fail_encoder(j, failed, ps(t)); })
      .def("fail_sway", [](Dock& d, int axis, bool failed, std::int64_t t) { d.fail_sway(axis, failed, ps(t)); })
      .def("encoder", [](Dock& d, int j, std::int64_t t) { return d.encoder(j, ps(t)); })
      .def("encoder_total", [](Dock& d, int j, std::int64_t t) { return d.encoder_total(j, ps(t)); })
      .def("sway", [](Dock& d, int axis, std::int64_t t) { return d.sway(axis, ps(t)); })
      .def("spreader_command", [](Dock& d, std::uint32_t v, std::int64_t t) { d.spreader_command(v, ps(t)); })
      .def("spreader_status", [](Dock& d, std::int64_t t) { return d.spreader_status(ps(t)); })
      .def("scan_rows", &Dock::scan_rows)
      .def("select_row", [](Dock& d, std::int32_t row, std::int64_t t) { d.select_row(row, ps(t)); })
      .def("scan_y", [](Dock& d, std::int64_t t) { return d.scan_y(ps(t)); })
      .def("scan_x0", &Dock::scan_x0)
      .def("scan_dx", &Dock::scan_dx)
      .def("scan_deck", &Dock::scan_deck)
      .def("profile", [](Dock& d, int i, std::int64_t t) { return d.profile(i, ps(t)); })
      .def_property_readonly("agv_count", &Dock::agv_count)
      .def("agv_x", [](Dock& d, int i, std::int64_t t) { return d.agv_x(i, ps(t)); })
      .def("agv_y", [](Dock& d, int i, std::int64_t t) { return d.agv_y(i, ps(t)); })
      .def("agv_heading", [](Dock& d, int i, std::int64_t t) { return d.agv_heading(i, ps(t)); })
      .def("agv_speed", [](Dock& d, int i, std::int64_t t) { return d.agv_speed(i, ps(t)); })
      .def("agv_status", [](Dock& d, int i, std::int64_t t) { return d.agv_status(i, ps(t)); })
      .def("agv_range", [](Dock& d, int i, int ray, std::int64_t t) { return d.agv_range(i, ray, ps(t)); })
      .def(
          "agv_scan",
          [](Dock& d, int i, std::int64_t t) {
            std::vector<std::int32_t> rays(range_rays);
            for (int ray = 0; ray < range_rays; ++ray) rays[static_cast<std::size_t>(ray)] = d.agv_range(i, ray, ps(t));
            return rays;
          },
          "agv_range of every ray")
      .def("range_scan", [](Dock& d, int i, std::int64_t t) { return d.range_scan(i, ps(t)); })
      .def_property_readonly("range_mount", &Dock::range_mount)
      .def("agv_period", [](Dock& d, int i, std::uint32_t us, std::int64_t t) { d.agv_period(i, us, ps(t)); })
      .def("agv_push", [](Dock& d, int i, std::int32_t speed, std::int32_t front, std::int32_t rear, std::int64_t t) {
        d.agv_push(i, speed, front, rear, ps(t));
      })
      .def("agv_push_wheels", [](Dock& d, int i, std::int32_t left, std::int32_t right, std::int64_t t) { d.agv_push_wheels(i, left, right, ps(t)); })
      .def("agv_reset_bumper", [](Dock& d, int i, std::int64_t t) { d.agv_reset_bumper(i, ps(t)); })
      .def_property_readonly("events", &Dock::events, py::return_value_policy::copy)
      .def_property_readonly("containers", &Dock::containers)
      .def("agv", &Dock::agv)
      .def_property_readonly("signal", &Dock::signal)
      .def_property_readonly("signals", &Dock::signals, py::return_value_policy::copy)
      .def_property_readonly("agv_signals", &Dock::agv_signals, py::return_value_policy::copy)
      .def_property_readonly("delivered", &Dock::delivered)
      .def_property_readonly("handover", &Dock::handover)
      .def_property_readonly("switches", &Dock::switches, py::return_value_policy::copy)
      .def_property_readonly("faulted", &Dock::faulted)
      .def_property_readonly("payload_mass", &Dock::payload_mass)
      .def_property_readonly("energy", &Dock::energy)
      .def("snapshot", [](const Dock& d) { return std::make_shared<DockState>(*d.snapshot()); })
      .def("restore", &Dock::restore)
      .def("state_hash", &Dock::state_hash);
}

// ODE's contact alone, for tests: a box-shaped body on a solid.
void bind_linkage(py::module_& m) {
  py::class_<LinkageParameters>(m, "LinkageParameters", "Bars in m, masses in kg (plant/linkage.hpp).")
      .def(py::init<>())
      FIELD(LinkageParameters, jib) FIELD(LinkageParameters, jib_mass) FIELD(LinkageParameters, fly)
      FIELD(LinkageParameters, fly_mass) FIELD(LinkageParameters, back) FIELD(LinkageParameters, tie)
      FIELD(LinkageParameters, tie_mass) FIELD(LinkageParameters, base_x) FIELD(LinkageParameters, base_z)
      FIELD(LinkageParameters, load);
  py::class_<Linkage>(m, "Linkage", "A level-luffing double-link jib in its plane, by IDA.")
      .def(py::init<const LinkageParameters&, double>(), py::arg("parameters"), py::arg("tolerance") = 1e-9)
      .def("place", &Linkage::place, py::arg("jib_angle"), py::arg("jib_rate") = 0.0)
      .def("advance", &Linkage::advance, py::arg("torque"), py::arg("seconds"))
      .def_property_readonly("angles", &Linkage::angles)
      .def_property_readonly("rates", &Linkage::rates)
      .def_property_readonly("nose", &Linkage::nose)
      .def_property_readonly("open", &Linkage::open)
      .def_property_readonly("energy", &Linkage::energy)
      .def_property_readonly("holding_torque", &Linkage::holding_torque)
      .def_property_readonly("joint_force", &Linkage::joint_force);
}

void bind_contact(py::module_& m) {
  m.def("swing_in_ode", &swing_in_ode, py::arg("crane"), py::arg("mass"), py::arg("q"), py::arg("qd"), py::arg("force"), py::arg("step"),
        py::arg("steps"));
  m.def(
      "drop_box",
      [](double mass, std::array<double, 3> size, double gap, double speed, double slope, double step, int steps) {
        LandingParameters p;
        ContactEngine engine(p);
        BodyShape shape{};
        shape.mass = mass;
        shape.inertia = {mass * (size[1] * size[1] + size[2] * size[2]) / 12, mass * (size[0] * size[0] + size[2] * size[2]) / 12,
                         mass * (size[0] * size[0] + size[1] * size[1]) / 12};
        const double x = 0.5 * size[0] - 0.1;
        const double y = 0.5 * size[1] - 0.1;
        shape.corners = {{{x, y, -0.5 * size[2]}, {x, -y, -0.5 * size[2]}, {-x, -y, -0.5 * size[2]}, {-x, y, -0.5 * size[2]}}};
        BodyState body;
        body.position = {0.0, 0.0, 0.5 * size[2] + gap};
        body.velocity = {0.0, 0.0, -speed};
        const std::array solid{make_solid(Solid::Kind::ground, -1, 0, 0, 0, 100, 100, -5.0, 0.0)};
        // A slope is a sideways pull and less weight: the floor stays level.
        const std::array force{mass * gravity * std::sin(slope), 0.0, mass * gravity * (1.0 - std::cos(slope))};
        std::vector<std::array<double, 4>> rows;
        for (int i = 0; i < steps; ++i) {
          const ContactResult r = engine.step(body, shape, force, {0.0, 0.0, 0.0}, solid, step);
          rows.push_back({body.position[2] - 0.5 * size[2], body.velocity[2], r.normal_force, body.position[0]});
        }
        return rows;
      },
      py::arg("mass"), py::arg("size"), py::arg("gap"), py::arg("speed"), py::arg("slope"), py::arg("step"), py::arg("steps"),
      "rows of (height of the underside, vertical speed, normal force, x)");
}

}  // namespace

void bind_plant(py::module_& core) {
  auto m = core.def_submodule("plant", "Crane, AGVs, containers, drives and sensors. Times are integer picoseconds.");
  m.attr("gravity") = gravity;
  bind_crane_parameters(m);
  bind_motion(m);
  bind_config(m);
  bind_alone(m);
  bind_agv_alone(m);
  bind_records(m);
  bind_dock(m);
  bind_contact(m);
  bind_linkage(m);
}
