#include "cmrc/configuration/dock/servo_law.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cmrc/tasks/ti_float.hpp"
#include "plant/numerics/math.hpp"

namespace cmrc {
namespace {

double derivative_time(const Config::Control::Joint& joint) { return 2 * joint.damping / joint.bandwidth_rad_s; }
double integral_time(const Config::Control::Joint& joint) {
  return joint.integral_time_s > 0 ? joint.integral_time_s : 6 / joint.bandwidth_rad_s;
}

// The inertia that a drive moves, without the swinging load, in the terms of ControlLaw::Row::k (docs/control.md): the
// rotor and everything that is stiffly connected.
std::array<double, 5> inertia(std::size_t channel, const plant::CraneParameters& p) {
  const bool gantry = p.machine == plant::CraneKind::gantry;
  const plant::DriveParameters& drive =
      p.drives.at(static_cast<std::size_t>(plant::drive_channels(p.machine).at(channel)));
  const double rotor = drive.rotor_inertia * drive.gear * drive.gear;
  switch (channel) {
    case 0:
      return gantry ? std::array<double, 5>{}
                    : std::array<double, 5>{rotor + p.gantry_mass + p.jib_mass + p.counterweight};
    case 1:
      if (gantry) return {rotor + p.gantry_mass + p.jib_mass};
      return {rotor + p.slew_inertia + p.counterweight * p.counterweight_radius * p.counterweight_radius +
                  p.jib_mass * p.a0 * p.a0,
              0, 2 * p.jib_mass * p.a0 * p.jib_centre, p.jib_inertia + p.jib_mass * p.jib_centre * p.jib_centre};
    case 2:
      if (gantry) return {rotor + p.jib_mass};
      return {rotor + p.jib_inertia + p.jib_mass * p.jib_centre * p.jib_centre, 0, 0, 0, p.jib * p.jib};
    case 3: return {rotor, 1};
    // Without the load: near the ground it hangs on falls that are soft in skew, and a gain that includes the load
    // would be several times too high.
    default: return {rotor + p.spreader_inertia};
  }
}

const Config::Control::Joint& joint_of(const Config::Control& control, plant::CraneKind machine, std::size_t channel) {
  const bool gantry = machine == plant::CraneKind::gantry;
  switch (channel) {
    case 0: return control.travel;
    case 1: return gantry ? control.travel : control.slew;
    case 2: return gantry ? control.trolley : control.luff;
    case 3: return control.hoist;
    default: return control.rotator;
  }
}

using Matrix = std::array<std::array<double, 6>, 6>;

Matrix squared(const Matrix& a) {
  Matrix b{};
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t k = 0; k < 6; ++k)
      for (std::size_t j = 0; j < 6; ++j) b[i][j] += a[i][k] * a[k][j];
  return b;
}

}  // namespace

plant::CraneParameters crane_parameters(const Config& config) {
  plant::DockConfig dock;
  if (config.dock.crane == CraneMachine::gantry) dock.crane = plant::gantry_crane();
  place_plant_parameters(dock, config.plant);
  return dock.crane;
}

std::vector<ControlJoint> control_joints(const Config::Control& control, const plant::CraneParameters& crane) {
  const bool gantry = crane.machine == plant::CraneKind::gantry;
  const auto of = [&](const char* name, const char* unit, const Config::Control::Joint& joint, int drive) {
    return ControlJoint{name, unit, &joint, &crane.drives.at(static_cast<std::size_t>(drive))};
  };
  std::vector<ControlJoint> all = {of("travel", "m_s", control.travel, 0)};
  if (gantry) {
    all.push_back(of("trolley", "m_s", control.trolley, 2));
  } else {
    all.push_back(of("slew", "rad_s", control.slew, 1));
    all.push_back(of("luff", "rad_s", control.luff, 2));
  }
  all.push_back(of("hoist", "m_s", control.hoist, 3));
  all.push_back(of("rotator", "rad_s", control.rotator, 4));
  return all;
}

ControlLaw control_law(const Config::Control& control, const plant::CraneParameters& crane) {
  ControlLaw law;
  for (std::size_t channel = 0; channel < control_channels; ++channel) {
    const Config::Control::Joint& joint = joint_of(control, crane.machine, channel);
    const plant::DriveParameters& drive =
        crane.drives.at(static_cast<std::size_t>(plant::drive_channels(crane.machine).at(channel)));
    ControlLaw::Row& row = law.rows.at(channel);
    row.k = inertia(channel, crane);
    for (double& term : row.k) term *= joint.bandwidth_rad_s * joint.bandwidth_rad_s / (drive.gear * drive.efficiency);
    row.n = joint.derivative_filter;
    row.derivative_s = derivative_time(joint);
    row.integral_s = integral_time(joint);
    row.share = joint.feed_forward;
  }
  law.sway = {control.sway_gain_m_s_rad, control.wind_observer_rad_s, control.sway_filter_s,
              control.sway_limit_mrad * 1e-3};
  return law;
}

// 2.3 m/s is 0.12 rad/s of slewing at 19 m; the rotator turns as fast to keep the box's heading.
double plan_speed(const Config::Control& c) {
  return 2.3 * std::min({c.slew.speed_limit / 0.12, c.luff.speed_limit / 0.05, c.rotator.speed_limit / 0.12});
}

std::array<Word, 7> speed_words(const Config::Control& c, plant::CraneKind machine) {
  const auto within = [](double v) { return ti_float(1 / v); };
  // For luffing the hoist pays out rope in addition to the load's own way.
  const Word vertical = within(0.8 * c.hoist.speed_limit), yaw = within(c.rotator.speed_limit), none = ti_float(0);
  if (machine == plant::CraneKind::gantry)
    return {within(c.trolley.speed_limit), vertical, yaw, within(c.travel.speed_limit), none, none, none};
  return {within(plan_speed(c)),      vertical, yaw, none, within(c.slew.speed_limit), within(c.luff.speed_limit),
          within(c.hoist.speed_limit)};
}

// State: place, speed and acceleration of the joint, then what PID keeps: P, D, the last error. Inertia 1, set-point 0.
double loop_radius(const Config::Control::Joint& settings, double h, double lag) {
  const double k = settings.bandwidth_rad_s * settings.bandwidth_rad_s, t_d = derivative_time(settings),
               t_i = integral_time(settings);
  const double n = settings.derivative_filter, filter = t_d / (t_d + n * h), decay = lag > 0 ? plant::exp(-h / lag) : 0;
  Matrix a{};
  for (std::size_t column = 0; column < 6; ++column) {
    std::array<double, 6> x{};
    x[column] = 1;
    const double e = -x[0], p = x[3] + k * (e - x[5]), d = filter * (x[4] + k * n * (e - x[5])), u = p + d,
                 gap = x[2] - u;
    const double place = x[0] + x[1] * h + u * h * h / 2 + gap * (lag * h - lag * lag * (1 - decay));
    const double speed = x[1] + u * h + gap * lag * (1 - decay);
    const std::array<double, 6> next = {place, speed, u + gap * decay, p + h * k / t_i * e, d, e};
    for (std::size_t row = 0; row < 6; ++row) a[row][column] = next[row];
  }
  // The root of the norm of a high power, computed by squaring; a common factor is taken out each time.
  double exponent = 0, power = 1;
  for (int i = 0; i < 24; ++i) {
    double largest = 0;
    for (const auto& row : a)
      for (const double value : row) largest = std::max(largest, std::fabs(value));
    if (!(largest > 0) || !std::isfinite(largest)) break;
    for (auto& row : a)
      for (double& value : row) value /= largest;
    exponent += plant::log(largest) / power;
    a = squared(a);
    power *= 2;
  }
  return plant::exp(exponent);
}

std::optional<ControlFault> control_fault(const Config& config, double period_s) {
  const plant::CraneParameters crane = crane_parameters(config);
  for (const ControlJoint& joint : control_joints(config.control, crane)) {
    const Config::Control::Joint& s = *joint.settings;
    const std::string table = "control." + joint.name + "_";
    if (const double radius = loop_radius(s, period_s, joint.drive->torque_lag); !(radius < 1)) {
      double low = 0, high = s.bandwidth_rad_s;
      for (int i = 0; i < 40; ++i) {
        Config::Control::Joint tried = s;
        tried.bandwidth_rad_s = (low + high) / 2;
        (loop_radius(tried, period_s, joint.drive->torque_lag) < 1 ? low : high) = tried.bandwidth_rad_s;
      }
      const std::string also =
          low > 0 ? fmt::format("below {:.3g} rad/s with its damping and integral time, ", low) : "";
      return ControlFault{
          {table + "bandwidth_rad_s", table + "damping", table + "integral_time_s", table + "derivative_filter"},
          fmt::format("the {}'s loop is unstable without any delay: with {:g} rad/s, damping {:g}, integral time {:g} "
                      "s, filter {:g} and a servo period of {:g} ms a pole has the modulus {:.4g}",
                      joint.name, s.bandwidth_rad_s, s.damping, integral_time(s), s.derivative_filter, period_s * 1e3,
                      radius),
          fmt::format("a bandwidth {}or a higher rates.servo_frequency_hz is expected (docs/control.md)", also)};
    }
    const bool moved =
        joint.name != "travel" ||
        crane.machine == plant::CraneKind::gantry;  // a slewing crane's travel does not move during a lift
    if (moved && s.speed_limit > joint.drive->rated_joint_speed()) {
      return ControlFault{
          {fmt::format("{}speed_limit_{}", table, joint.unit)},
          fmt::format("{:g} is above the drive's rated speed, {:.4g}", s.speed_limit, joint.drive->rated_joint_speed()),
          "a limit up to the rated speed is expected"};
    }
  }
  if (config.dock.ramp_speed_m_s > config.control.hoist.speed_limit) {
    return ControlFault{{"control.hoist_speed_limit_m_s"},
                        fmt::format("{:g} m/s is below dock.ramp_speed_m_s, {:g} m/s", config.control.hoist.speed_limit,
                                    config.dock.ramp_speed_m_s),
                        "a limit of at least the ramps' speed is expected"};
  }
  return std::nullopt;
}

}  // namespace cmrc
