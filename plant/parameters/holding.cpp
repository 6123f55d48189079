#include "plant/parameters/holding.hpp"

#include <fmt/format.h>

#include "plant/numerics/math.hpp"

namespace plant {
namespace {

const DriveParameters& drive(const CraneParameters& p, Joint joint) {
  return p.drives[static_cast<std::size_t>(joint)];
}

// N or N m at the joint.
double hoist_force(const CraneParameters& p, double load) { return gravity * (p.spreader_mass + load); }

// With the jib at its flattest, where it is greatest; 0 on a gantry.
double luff_force(const CraneParameters& p, double load) {
  if (p.machine == CraneKind::gantry) return 0.0;
  const double flattest = p.lower[static_cast<std::size_t>(Joint::luff)];
  return gravity * ((p.spreader_mass + load) * p.jib + p.jib_mass * p.jib_centre) * cos(flattest);
}

double motor_torque(const DriveParameters& d, double force) { return force / (d.gear * d.efficiency); }

std::string too_weak(const char* name, const char* where, const DriveParameters& d, double force, double load,
                     double spreader) {
  const double needed = motor_torque(d, force);
  const std::string holds =
      fmt::format("to hold {:.0f} kg below a spreader of {:.0f} kg{} the {} needs", load, spreader, where, name);
  if (needed > d.rated_torque)
    return fmt::format("{} {:.0f} N m, more than its rated torque of {:.0f} N m", holds, needed, d.rated_torque);
  if (force > d.brake * d.rated_force())
    return fmt::format("{} a brake of {:.2f} times its rated force, not {:.2f}", holds, force / d.rated_force(),
                       d.brake);
  return {};
}

}  // namespace

double hoist_holding_torque(const CraneParameters& p, double load) {
  return motor_torque(drive(p, Joint::hoist), hoist_force(p, load));
}

std::string cannot_hold(const CraneParameters& p, double load) {
  std::string hoist = too_weak("hoist", "", drive(p, Joint::hoist), hoist_force(p, load), load, p.spreader_mass);
  if (!hoist.empty() || p.machine == CraneKind::gantry) return hoist;
  return too_weak("luff drive", " with the jib at its flattest", drive(p, Joint::luff), luff_force(p, load), load,
                  p.spreader_mass);
}

}  // namespace plant
