#include "cmrc/programs/plant_constants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <numbers>
#include <string_view>

#include "cmrc/configuration/rows/value.hpp"
#include "cmrc/tasks/ti_float.hpp"
#include "machine/system/shared_numbers.hpp"
#include "plant/dock/sensors.hpp"
#include "plant/numerics/math.hpp"

namespace cmrc {
namespace {

using plant::CraneParameters;
using plant::DriveParameters;
using plant::Joint;

constexpr std::size_t of(Joint joint) { return static_cast<std::size_t>(joint); }

class Placer {
 public:
  explicit Placer(toolchain::Image& image) : image_(image), lift_(image.symbol("LIFT")) {}

  /// Words of a constant that _start copies to on-chip RAM; `label` is its address there.
  void constant(std::string_view label, std::initializer_list<double> values, toolchain::Word offset = 0) {
    put(image_.symbol(label) + lift_ + offset, label, values);
  }
  /// Words of a table that stays in the image.
  void table(std::string_view label, std::initializer_list<double> values) { put(image_.symbol(label), label, values); }
  toolchain::Word symbol(std::string_view label) const { return image_.symbol(label); }

 private:
  void put(toolchain::Address at, std::string_view label, std::initializer_list<double> values) {
    for (const double value : values) {
      toolchain::Word* word = image_.word_at(at++);
      if (word == nullptr)
        throw ConfigError(fmt::format(
            "machine.programs: {} lies in no loaded section; a constant of plant_constants.asm is expected there",
            label));
      *word = ti_float(value);
    }
  }

  toolchain::Image& image_;
  toolchain::Word lift_;
};

void place_geometry(Placer& to, const CraneParameters& p) {
  const bool gantry = p.machine == plant::CraneKind::gantry;
  to.constant("K_A0", {p.a0});
  to.constant("K_JIB", {p.jib});
  to.constant("K_PIVOT", {p.pivot_height});
  to.constant("K_JIB_SQUARED", {gantry ? 0.0 : p.jib * p.jib});
  to.constant("K_ONE_OVER_JIB", {1.0 / p.jib});
  to.constant("K_PD_LIFT", {gantry ? 0.0 : p.jib});
  to.constant("K_PD_TURN", {gantry ? 0.0 : 1.0});
  if (gantry) {
    to.table("gantry_masses", {p.gantry_mass + p.jib_mass, p.jib_mass});
    to.table("gantry_limits", {p.lower[of(Joint::gantry)], p.upper[of(Joint::gantry)], p.lower[of(Joint::luff)],
                               p.upper[of(Joint::luff)], p.lower[of(Joint::hoist)], p.upper[of(Joint::hoist)]});
  } else {
    to.constant("K_IK_COS_LOW", {plant::cos(p.upper[of(Joint::luff)])});
    to.constant("K_IK_COS_HIGH", {plant::cos(p.lower[of(Joint::luff)])});
  }
}

void place_masses(Placer& to, const CraneParameters& p) {
  to.constant("K_TQ_JIB_MOMENT", {p.jib_mass * p.jib_centre});
  to.constant("K_TQ_A0_MASS", {p.jib_mass * p.a0});
  to.constant("K_TQ_CW_MOMENT", {p.counterweight * p.counterweight_radius});
  to.constant("K_TQ_JIB_PIVOT", {p.jib_inertia + p.jib_mass * p.jib_centre * p.jib_centre});
  to.constant("K_TQ_SLEW_FIXED", {p.slew_inertia + p.counterweight * p.counterweight_radius * p.counterweight_radius});
  to.constant("K_TQ_JIB_INERTIA", {p.jib_inertia});
  to.constant("K_TQ_JIB_CENTRE", {p.jib_centre});
  to.constant("K_TQ_JIB_MASS", {p.jib_mass});
  to.constant("K_TQ_GANTRY", {p.gantry_mass + p.jib_mass + p.counterweight});
  to.constant("K_TQ_SPREADER", {p.spreader_mass});
  to.constant("K_TQ_YAW_BASE", {p.spreader_inertia});
  to.constant(
      "K_TQ_YAW_PER_KG",
      {(plant::container_length * plant::container_length + plant::container_width * plant::container_width) / 12.0});
}

/// The rows of the table of Newton-Euler: NE_P, NE_S, NE_MASS and NE_INERTIA of each link.
void place_links(Placer& to, const CraneParameters& p) {
  const auto at = [&](toolchain::Word link, std::string_view field, toolchain::Word axis, double value) {
    to.constant("K_NE_TABLE", {value}, link * to.symbol("NE_ROW") + to.symbol(field) + axis);
  };
  constexpr toolchain::Word x = 0, y = 1, z = 2;
  at(0, "NE_MASS", 0, p.gantry_mass);
  if (p.machine == plant::CraneKind::gantry) {
    at(1, "NE_P", z, p.pivot_height);
    at(1, "NE_MASS", 0, p.jib_mass);
    return;
  }
  at(1, "NE_S", x, -p.counterweight_radius);
  at(1, "NE_MASS", 0, p.counterweight);
  at(1, "NE_INERTIA", z, p.slew_inertia);
  at(2, "NE_P", x, p.a0);
  at(2, "NE_P", z, p.pivot_height);
  at(2, "NE_S", x, p.jib_centre);
  at(2, "NE_MASS", 0, p.jib_mass);
  at(2, "NE_INERTIA", y, p.jib_inertia);
  at(2, "NE_INERTIA", z, p.jib_inertia);
  at(3, "NE_P", x, p.jib);
}

void place_drives(Placer& to, const CraneParameters& p, const plant::SensorParameters& sensors) {
  toolchain::Word channel = 0;
  for (const int joint : plant::drive_channels(p.machine)) {
    const DriveParameters& d = p.drives[static_cast<std::size_t>(joint)];
    const bool spare = p.machine == plant::CraneKind::gantry && joint == static_cast<int>(Joint::slew);
    const double force = d.rated_force(), speed = d.rated_joint_speed(), most = d.maximum_torque();
    if (!spare) {
      to.constant("K_TQ_DRIVES",
                  {d.rotor_inertia * d.gear * d.gear, d.coulomb * force, 1.0 / (d.smooth_speed * speed),
                   d.viscous * force / speed, 1.0 / (d.gear * d.efficiency)},
                  5 * channel);
      to.constant("K_PD_UNIT", {2.0 * std::numbers::pi / plant::counts_per_revolution / d.gear}, channel);
      to.constant("K_PD_JOINTS", {most, plant::largest_torque_code / most}, 3 * channel);
    } else {
      to.constant("K_TQ_DRIVES", {0.0, 0.0, 0.0, 0.0, 0.0}, 5 * channel);
      to.constant("K_PD_UNIT", {0.0}, channel);
    }
    ++channel;
  }
  to.constant("K_PD_SWAY_UNIT", {sensors.sway_range / plant::sway_codes});
}

void place_container(Placer& to) {
  to.constant("K_GP_HALF_LENGTH", {0.5 * plant::container_length});
  to.constant("K_GP_HALF_WIDTH", {0.5 * plant::container_width});
  to.constant("K_ID_LENGTH", {plant::container_length});
  to.constant("K_ID_HALF_WIDTH", {0.5 * plant::container_width});
  to.constant("K_ID_QUANTUM", {0.5e-3 * plant::scan_quantum});
}

void place_vehicle(Placer& to, const plant::AgvParameters& p, double container_mass) {
  const double braking = std::min(p.braking, p.emergency), brake = 0.8 * braking;
  to.constant("K_TA_ACCELERATE", {0.9 * p.acceleration});
  to.constant("K_TA_BRAKE", {brake});
  to.constant("K_TA_BRAKE_TWICE", {2.0 * brake});
  to.constant("K_IA_HALF_BASE", {0.5 * (p.front + p.rear)});
  to.constant("K_IA_STEER_LIMIT", {p.steer_limit});
  to.constant("K_IA_DRIFT_EMPTY", {p.mass / (2.0 * p.cornering)});
  to.constant("K_IA_DRIFT_LOADED", {(p.mass + container_mass) / (2.0 * p.cornering)});
  const double half = 0.5 * p.width + 0.4, stops = 0.9 * braking;
  to.constant("K_AV_HALF", {half});
  to.constant("K_AV_CLOSE", {half + 0.5});
  to.constant("K_AV_NEEDS", {half + 0.15});
  to.constant("K_AV_WAY", {2.0 * half});
  to.constant("K_AV_HALF_LENGTH", {0.5 * p.length});
  to.constant("K_AV_SWING", {-0.125 * p.length * p.length});
  to.constant("K_AV_REAR", {0.5 * p.length + 1.6});
  to.constant("K_AV_PASSED", {p.length + 1.2});
  to.constant("K_AV_B", {stops});
  to.constant("K_AV_TWICE_OVER_B", {2.0 / stops});
  to.constant("K_AV_ONE_OVER_B", {1.0 / stops});
  to.constant("K_DW_HALF_OVER_B", {0.5 / stops});
  to.constant("K_DW_RADIUS2", {half * half});
}

}  // namespace

void place_plant_constants(toolchain::Image& image, const plant::DockConfig& dock, double container_mass) {
  if (const auto wrong = machine::contradiction(image)) throw ConfigError("machine.programs: " + *wrong);
  Placer to(image);
  to.constant("K_GRAVITY", {plant::gravity});
  to.constant("K_ONE_OVER_G", {1.0 / plant::gravity});
  place_geometry(to, dock.crane);
  place_masses(to, dock.crane);
  place_links(to, dock.crane);
  place_drives(to, dock.crane, dock.sensors);
  place_container(to);
  place_vehicle(to, dock.agv, container_mass);
}

}  // namespace cmrc
