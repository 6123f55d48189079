#pragma once
// The parameters of a dock: every value has a default and a unit (docs/plant.md gives the sources).
#include <array>
#include <cstdint>
#include <numbers>
#include <vector>

#include "plant/numerics/integrator.hpp"
#include "plant/parameters/basics.hpp"

namespace plant {

// The drive of one joint. "Motor" sums the motors that share the joint.
struct DriveParameters {
  double rated_torque;            // N m, motor side
  double rated_speed = 157.0;     // motor rad/s
  double gear;                    // motor rad per joint unit (rad or m)
  double rotor_inertia;           // kg m2, motor side
  double efficiency = 0.88;       // of the gear
  double torque_lag = 3e-3;       // s, first-order current loop
  double coulomb = 0.03;          // F_c as a share of the rated joint force gear * rated_torque
  double stribeck = 1.3;          // F_s / F_c
  double viscous = 0.015;         // share of the rated joint force at rated joint speed
  double smooth_speed = 0.01;     // v_0 of the tanh, as a share of the rated joint speed
  double stribeck_speed = 0.02;   // v_s, share of the rated joint speed
  double brake = 2.0;             // holding brake, as a share of the rated joint force
  double peak = 1.5;              // u_max, the torque at code 2047, as a share of the rated torque
  double overspeed = 1.15;        // the drive trips above this share of its rated speed,
  double overspeed_time = 0.010;  // s, if the overspeed lasts this long
  double saturation_time = 0.5;   // s, |code| = 2047 without a break for this time trips the drive
  double saturation_swings = 10;  // this number of swings of the code from one end to the other, each within that time
                                  // of the one before, trips it too
  double thermal_time = 1800.0;   // s, time constant of the thermal model: heat follows (torque / rated torque)^2
  double thermal_trip = 1.2;      // heat that trips it, as a share of the heat at rated torque; the warning is at 1

  double maximum_torque() const { return peak * rated_torque; }  // N m at code 2047
  double rated_force() const { return gear * rated_torque; }     // N or N m at the joint
  double rated_joint_speed() const { return rated_speed / gear; }
};

// The portal of a crane: four upright legs on two rails along the quay, which travel with the crane. leg 0: none.
struct Portal {
  double along = 5.0;                       // m, distance of the legs before s and behind it
  double landside = -5.0, waterside = 5.0;  // m, y of the rails
  double leg = 1.0;                         // m, side of a leg's square section
  double height = 14.0;                     // m
};

// Slewing and luffing jib crane, plant-and-bus.md 1.2 to 1.4 (docs/plant.md).
struct CraneParameters {
  CraneKind machine = CraneKind::slewing;
  Portal portal;
  double a0 = 2.5;                    // m, luff pivot from the slew axis
  double jib = 32.0;                  // m, L
  double pivot_height = 22.0;         // m, h_p
  double gantry_mass = 180e3;         // kg, m_g: all travelling mass except jib, counterweight and load
  double slew_inertia = 4.0e6;        // kg m2, J_s
  double jib_mass = 22e3;             // kg, m_j
  double jib_centre = 14.0;           // m, c_j along the jib
  double jib_inertia = 1.88e6;        // kg m2 about the jib's own centre, I_j
  double counterweight = 60e3;        // kg, m_cw
  double counterweight_radius = 7.0;  // m, r_cw
  double spreader_mass = 10e3;        // kg with headblock
  double spreader_inertia = 1.25e5;   // kg m2 about the vertical
  double rated_load = 40e3;           // kg below the spreader; heavier containers are refused
  double sway_damping = 0.007;        // share of critical, of both sway angles
  bool gear_losses = false;  // gears also have losses when the load drives: the motor's torque is then divided by the
                             // efficiency; false: it is always multiplied
  bool stiction =
      false;  // dry friction is exact: joints stick below F_s and break away; else it is smoothed by the tanh
  Joints lower = {-60.0, -6.2831853071795862, 0.3490658503988659, 4.0, -6.2831853071795862};
  Joints upper = {60.0, 6.2831853071795862, 1.3962634015954636, 60.0, 6.2831853071795862};
  std::array<DriveParameters, joint_count> drives = {{
      {.rated_torque = 382.0, .gear = 314.0, .rotor_inertia = 0.4},                         // 4 x 15 kW
      {.rated_torque = 1911.0, .gear = 1250.0, .rotor_inertia = 4.8},                       // 4 x 75 kW
      {.rated_torque = 7643.0, .gear = 3140.0, .rotor_inertia = 20.0, .efficiency = 0.85},  // 4 x 300 kW
      {.rated_torque = 5732.0, .gear = 1.0 / 0.00955, .rotor_inertia = 24.0},               // 2 x 450 kW
      {.rated_torque = 70.0, .gear = 1250.0, .rotor_inertia = 0.06},  // 2 x 5.5 kW; as fast as the slewing
  }};
};

// A ship-to-shore gantry with the figures of plant-and-bus.md 1.4: trolley 150 m/min, outreach 38.5 m, backreach 15 m,
// lift 31 m above the rail.
CraneParameters gantry_crane();

struct JointName {
  const char* name;
  const char* unit;
};

// The names of a crane's joints in signals and reports.
std::array<JointName, joint_count> joint_names(CraneKind);

// The joint of each of the five channels of drives and encoders on the bus. On the slewing crane they are in order. On
// a gantry the travel has channel 1, which is slewing's (either moves the load tangentially), and channel 0 has no
// moving joint.
std::array<int, joint_count> drive_channels(CraneKind);

// The payload near contact (level L2) and the landing.
struct LandingParameters {
  double fall_stiffness = 5e7;    // N: stiffness of one of the four falls is this / its length
  double fall_damping = 2e4;      // N s/m, each fall
  double fall_spread_x = 1.5;     // m, half distance of the falls, radial
  double fall_spread_y = 1.5;     // m, tangential
  double yaw_stiffness = 2e6;     // N m/rad between rotator and load (skew of the reeving)
  double yaw_damping = 2.5e5;     // N m s/rad
  double corner_stiffness = 1e7;  // N/m, each corner
  double corner_damping = 1.5e5;  // N s/m
  double friction = 0.4;
  double near = 0.3;             // m, clearance at which the payload becomes a body
  double away = 0.4;             // m, clearance at which it hangs on the ideal rope again
  bool guides = true;            // flipper guides and deck cones
  double guide_window = 0.15;    // m, lateral error that they still catch
  double guide_height = 0.3;     // m above the surface at which they begin
  double guide_stiffness = 3e5;  // N/m, each corner
  double guide_damping = 2e4;    // N s/m
  double seat_error = 0.025;     // m, lateral error per corner that lets a corner seat
  double seat_gap = 0.005;       // m, a corner switch closes below this gap
  double touch_speed = 0.25;     // m/s, faster touches are reported as hard landings
  double touch_sway = 0.1;       // m/s, the same for the horizontal speed
  bool strict = false;  // a hard or crooked touch does not count: corner switches stay open until the touch is repeated
  double yaw_error = std::numbers::pi / 180.0;  // rad, greatest rotation of the load in a strict touch
  double lock_time = 0.8;                       // s, twist locks
};

// The drive of an AGV: two steered axles, or two driven wheels beside its middle and castors.
enum class AgvDrive : std::uint8_t { steered, differential };

// Container transporter, plant-and-bus.md 1.4 and 1.5.
struct AgvParameters {
  AgvDrive drive = AgvDrive::steered;
  double mass = 25e3;                 // kg, empty
  double length = 14.8, width = 3.0;  // m
  double front = 4.5, rear = 4.5;     // m, axles from the centre (l_f, l_r)
  double yaw_inertia = 4.8e5;         // kg m2, empty
  double deck_height = 1.6;           // m
  double cornering = 4e5;             // N/rad per axle
  double adhesion = 0.7;
  double rolling = 0.01;                      // C_rr
  double drag = 5.0;                          // N s2/m2, C_d
  double steer_limit = std::numbers::pi / 6;  // rad
  double steer_rate = 0.35;                   // rad/s
  double steer_lag = 0.2;                     // s
  double drive_lag = 0.3;                     // s
  double acceleration = 0.5;                  // m/s2, of the drive's speed ramp
  double braking = 1.0;                       // m/s2, of the ramp
  double emergency = 2.0;                     // m/s2, greatest braking by the brakes
  double blend_speed = 0.5;                   // m/s, kinematic model below
  double track = 2.4;                         // m between the two wheels (differential)
  double wheel_slip = 4e5;                    // N s/m, force per slip speed of each wheel (differential)
  bool protective_field = false;   // the unit itself slows down for objects that its range sensor sees in its way
  double protective_margin = 1.0;  // m, distance to such an object at which it stops
  double speed_gain = 2.0;         // 1/s, speed loop (mass times gain times error)
  double speed_integral = 0.5;     // 1/s, its integral
};

// A sampling clock with a deviation from its nominal frequency and phase. It samples at the first point of the grid at
// or after a tick: at the first latch; for AGVs at their first step of 1 ms.
struct SampleClock {
  std::int64_t ppm = 0;       // its frequency is (1 + ppm / 10^6) times the nominal one
  std::int64_t phase_ps = 0;  // of its first tick
};

struct SensorParameters {
  double sway_range = std::numbers::pi / 18;          // rad at code 2048 (10 degrees)
  bool second_sway = true;                            // there is a second sway sensor
  double sway_noise = 0.02 * std::numbers::pi / 180;  // rad, standard deviation
  double range_rate = 0.0;                // Hz, of the AGVs' range sensors; 0: each of the AGVs' steps, 1 kHz
  SampleClock sway_clock;                 // nominal 100 Hz
  std::vector<SampleClock> range_clocks;  // by AGV, with a rate only; missing ones keep the nominal clock
  double range_dropout = 0.0;             // probability that a ray brings no valid echo; with a rate only
  std::uint64_t seed = 1;
};

// Wind on the load; off by default.
struct WindParameters {
  double mean = 0.0;  // m/s
  double gust =
      0.0;  // m/s, sigma: standard deviation of the speed (plant/scene/wind.hpp); 0.13 times the mean is usual
  double direction = 0.0;  // rad, direction the wind blows towards: 0 along the quay, pi/2 towards the ship
  // Drag coefficient times face, m2 (control-notes.md 3): a container across the wind and along it, and the spreader
  // alone.
  double side_area = 38.0, end_area = 7.6, spreader_area = 8.0;
  std::uint64_t seed = 1;

  bool blows() const { return mean != 0.0 || gust != 0.0; }
};

// A moored ship's motion: three sinusoids for each of surge, sway, heave, roll and pitch (plant-and-bus.md 1.5). Off by
// default.
struct ShipMotion {
  double scale = 0.0;    // of the amplitudes: surge 0.2 m, sway 0.1 m, heave 0.1 m, roll 0.5 deg, pitch 0.1 deg
  double draught = 0.0;  // m by which the ship rises per kg that leaves it; 3.3e-7 is usual
  std::uint64_t seed = 1;

  bool moves() const { return scale != 0.0 || draught != 0.0; }
};

// Box in the world, m.
struct Box {
  double x_min, x_max, y_min, y_max, z_min, z_max;
};

struct Waypoint {
  double time, x, y;  // s, m
};

// A person, a truck, a post: an upright cylinder that follows its waypoints without regard to obstacles. With one
// waypoint it does not move.
struct Mover {
  double radius, height;  // m
  std::vector<Waypoint> path;
  bool repeats = false;  // from the first waypoint again after the last
};

inline constexpr double container_length = 12.192, container_width = 2.438, container_height = 2.591;  // m, 40 ft
inline constexpr double spreader_height = 1.0;  // m; as long and wide as the container

struct ContainerPlace {
  double x, y, z;  // m, centre of the underside
  double yaw;      // rad
  double mass;     // kg, gross
};

// A piece of lane, driven forward: curvature 1/m (left positive), suitable speed m/s.
struct LaneSegment {
  double x, y, heading, length, curvature, speed;
};

struct Pose {
  double x, y, heading;
};

struct CranePose {
  double s, x, y, z, yaw;  // gantry, and the middle of the spreader's underside, m and rad
};

struct Layout {
  double deck = 3.909;                      // m, z of the empty ship deck under the bay
  std::vector<double> rows = {24.0, 26.6};  // m, y of the bay's rows
  double scan_x0 = -25.6, scan_dx = 0.4;    // m, bay scanner
  std::vector<ContainerPlace> containers;   // on the ship
  double container_mass = 24e3;             // kg, for those in a layout file without a mass
  Box ship = {-40.0, 40.0, 20.0, 36.0, -5.0, 3.909};
  std::vector<Box> no_go;        // boxes for the grab path (containers are not among them)
  std::vector<Mover> movers;     // obstacles for the AGVs, posts among them
  Pose spot = {22.0, 8.0, 0.0};  // loading spot
  Pose warehouse = {10.0, -16.0, std::numbers::pi};
  double warehouse_radius = 2.0;                 // m, an AGV that stops within this distance is served
  double warehouse_take = 10.0;                  // s
  double slot_spacing = 18.0;                    // m, waiting slots behind the spot
  std::array<std::vector<LaneSegment>, 3> legs;  // 1 to the warehouse, 2 to the spot, 3 home (the spot too)
};

struct DockConfig {
  CraneParameters crane;
  LandingParameters landing;
  AgvParameters agv;
  SensorParameters sensors;
  WindParameters wind;
  ShipMotion ship;
  Layout layout;
  bool collisions = true;  // AGVs stop at obstacles; false: they pass through them
  bool rigid = false;      // level L0: the free payload does not sway; else L1
  int agv_count = 1;
  std::vector<SampleClock>
      unit_clocks;  // by AGV: the clock of its drive unit, nominal 100 Hz; missing ones keep the nominal clock
  CranePose home = {0.0, 12.0, 16.0, 14.0, 0.0};
  int drive_delay = 0;         // latches by which a drive takes its code late, for experiments
  double drive_timeout = 0.1;  // s, a drive without a torque code for this time brakes; 0: never
  Method method = Method::erk;
  double tolerance = 1e-8;       // relative, of the integrators
  int signal_decimation = 0;     // interval in latches at which signals are recorded; 0: never
  int signal_rows_max = 65'536;  // at this number of rows every second one is removed, and the interval doubles
};

// The dock of docs/plant.md: eight containers in two rows and two tiers, a one-way loop of lane, n AGVs queueing at the
// spot.
DockConfig default_dock(int agv_count = 1);

// The same with a ship-to-shore gantry: the ship alongside, four rows of one bay and of its neighbours, the spot
// between the gantry's rails.
DockConfig gantry_dock(int agv_count = 1);

// The lanes of that dock, with another spot and warehouse (24 m apart across the quay).
std::array<std::vector<LaneSegment>, 3> default_loop(const Layout&, int agvs);

// The pose at a distance along a piece of lane.
Pose along(const LaneSegment&, double way);

// Distance of a point from a piece of lane, m; 1e9 if the point is before an arc's beginning or behind its end.
double distance_from(const LaneSegment&, double x, double y);

// The place of AGV i at the start: the spot, and the slots behind it.
Pose start_of_agv(const Layout&, int i);

}  // namespace plant
