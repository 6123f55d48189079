#pragma once
// The servo's law from the configuration ([control]; docs/control.md), and whether its loops are stable.
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "cmrc/tasks/words.hpp"
#include "plant/parameters/config.hpp"

namespace cmrc {

inline constexpr std::size_t control_channels = 5;
inline constexpr std::size_t control_sway = 4;  ///< words against sway

/// The values of PID's law by channel of drives and encoders; SI units.
struct ControlLaw {
  struct Row {
    /// K = k[0] + k[1] m + cos phi (k[2] + cos phi (k[3] + k[4] m)), motor N m per m or rad
    std::array<double, 5> k{};
    double n = 20, derivative_s = 1, integral_s = 1, share = 1;
    bool operator==(const Row&) const = default;
  };
  std::array<Row, control_channels> rows;
  std::array<double, control_sway> sway{};  ///< m/s per rad, rad/s, s, rad
};
ControlLaw control_law(const Config::Control& control, const plant::CraneParameters& crane);

/// The load's greatest speed in plan of a slewing crane's leg, m/s.
double plan_speed(const Config::Control& control);
/// The words of CR_SPEED: the speed limits of a leg, as 1 / v.
std::array<Word, 7> speed_words(const Config::Control& control, plant::CraneKind machine);

/// The crane of a configuration: its drives and masses, known before the dock is built.
plant::CraneParameters crane_parameters(const Config& config);

/// One joint's settings, with the name in its keys.
struct ControlJoint {
  std::string name, unit;  ///< "hoist", "m_s"
  const Config::Control::Joint* settings;
  const plant::DriveParameters* drive;
};
/// The joints of a crane in the order of the channels, without the gantry's spare one.
std::vector<ControlJoint> control_joints(const Config::Control& control, const plant::CraneParameters& crane);

/// The largest modulus of a pole of one joint's sampled loop: PID, code held for `period_s`, torque lag, the joint's
/// inertia; no delay. It does not depend on the inertia, because the gain is proportional to it. Below 1: stable.
double loop_radius(const Config::Control::Joint& settings, double period_s, double torque_lag_s);

/// Impossible settings.
struct ControlFault {
  std::vector<std::string> keys;  ///< which are wrong together; the first is the one to change
  std::string what, right;
};
std::optional<ControlFault> control_fault(const Config& config, double period_s);

}  // namespace cmrc
