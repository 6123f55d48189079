#include "cmrc/configuration/dock/plant_parameters.hpp"

#include <fmt/format.h>

#include <charconv>
#include <numbers>
#include <stdexcept>
#include <string>

#include "plant/parameters/check.hpp"
#include "plant/parameters/holding.hpp"
#include "plant/parameters/parameter_rows.hpp"

namespace cmrc {
namespace {

using plant::CraneKind;
using plant::DockConfig;
using plant::Joint;
using plant::Where;

constexpr double degree = std::numbers::pi / 180.0;

struct JointRow {
  std::string_view name;  // name of its table
  Joint joint;
  bool turns;  // the unit is rad, else m
};
constexpr JointRow of_slewing[] = {{"travel", Joint::gantry, false},
                                   {"slew", Joint::slew, true},
                                   {"luff", Joint::luff, true},
                                   {"hoist", Joint::hoist, false},
                                   {"rotate", Joint::rotator, true}};
constexpr JointRow of_gantry[] = {{"travel", Joint::gantry, false},
                                  {"trolley", Joint::luff, false},
                                  {"hoist", Joint::hoist, false},
                                  {"rotate", Joint::rotator, true}};

class Keys {
 public:
  std::vector<PlantParameter> all;

  void crane(CraneKind machine, const std::string& table) {
    const bool slewing = machine == CraneKind::slewing;
    begin(table, machine);
    const Where here = slewing ? Where::slewing : Where::gantry;
    keys(plant::crane_rows(), here, [](DockConfig& c) -> plant::CraneParameters& { return c.crane; });
    keys(plant::portal_rows(), here, [](DockConfig& c) -> plant::Portal& { return c.crane.portal; });
    for (const JointRow& joint :
         slewing ? std::span<const JointRow>(of_slewing) : std::span<const JointRow>(of_gantry)) {
      begin(fmt::format("{}.{}", table, joint.name), machine);
      drive(joint);
    }
  }

  void vehicle() {
    begin("agv", std::nullopt);
    keys(plant::agv_rows(), Where::everywhere, [](DockConfig& c) -> plant::AgvParameters& { return c.agv; });
  }

  void landing() {
    begin("landing", std::nullopt);
    keys(plant::landing_rows(), Where::everywhere,
         [](DockConfig& c) -> plant::LandingParameters& { return c.landing; });
  }

 private:
  void begin(std::string table, std::optional<CraneKind> machine) {
    table_ = std::move(table);
    machine_ = machine;
  }
  void key(std::string_view name, std::string_view unit, double minimum, double maximum, std::string_view meaning,
           std::string_view source, std::function<double&(DockConfig&)> at, double scale) {
    all.push_back({fmt::format("{}.{}", table_, name), std::string(unit), scale, minimum, maximum, std::string(meaning),
                   std::string(source), machine_, std::move(at)});
  }
  template <class P, class Owner>
  void keys(std::span<const plant::ParameterRow<P>> rows, Where here, Owner owner) {
    for (const auto& row : rows)
      if (row.where == Where::everywhere || row.where == here)
        key(
            row.key, row.unit, row.minimum, row.maximum, row.meaning, row.source,
            [owner, member = row.at](DockConfig& c) -> double& { return owner(c).*member; }, row.scale);
  }
  void drive(const JointRow& joint) {
    const auto j = static_cast<std::size_t>(joint.joint);
    const std::string_view unit = joint.turns ? "deg" : "m";
    const double scale = joint.turns ? degree : 1.0;
    key(
        fmt::format("lower_{}", unit), unit, -1e4, 1e4, "lower end stop", "assumed",
        [j](DockConfig& c) -> double& { return c.crane.lower[j]; }, scale);
    key(
        fmt::format("upper_{}", unit), unit, -1e4, 1e4, "upper end stop", "assumed",
        [j](DockConfig& c) -> double& { return c.crane.upper[j]; }, scale);
    keys(plant::drive_rows(), joint.turns ? Where::turning : Where::sliding,
         [j](DockConfig& c) -> plant::DriveParameters& { return c.crane.drives[j]; });
  }

  std::string table_;
  std::optional<CraneKind> machine_;
};

DockConfig dock_with(CraneKind machine) {
  return machine == CraneKind::gantry ? plant::gantry_dock() : plant::default_dock();
}

/// The nearest number with twelve digits: a default converted from other units gets its intended decimal form.
double written(double value) {
  const std::string text = fmt::format("{:.12g}", value);
  double out = 0;
  std::from_chars(text.data(), text.data() + text.size(), out);
  return out;
}

}  // namespace

std::span<const PlantParameter> plant_parameters() {
  static const std::vector<PlantParameter> all = [] {
    Keys keys;
    keys.crane(CraneKind::slewing, "slewing");
    keys.crane(CraneKind::gantry, "gantry");
    keys.vehicle();
    keys.landing();
    return std::move(keys.all);
  }();
  return all;
}

const std::vector<double>& plant_defaults() {
  static const std::vector<double> all = [] {
    DockConfig slewing = dock_with(CraneKind::slewing), gantry = dock_with(CraneKind::gantry);
    std::vector<double> values;
    for (const PlantParameter& row : plant_parameters())
      values.push_back(written(row.at(row.machine == CraneKind::gantry ? gantry : slewing) / row.scale));
    return values;
  }();
  return all;
}

void place_plant_parameters(DockConfig& dock, const std::vector<double>& values) {
  const auto rows = plant_parameters();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (values[i] == plant_defaults()[i] || (rows[i].machine && *rows[i].machine != dock.crane.machine)) continue;
    rows[i].at(dock) = values[i] * rows[i].scale;
  }
}

std::optional<PlantFault> plant_fault(CraneKind machine, const std::vector<double>& values, double container_mass) {
  DockConfig dock = dock_with(machine);
  place_plant_parameters(dock, values);
  try {
    plant::check(dock.crane);
    plant::check(dock.agv);
    plant::check(dock.landing);
  } catch (const std::invalid_argument& error) {
    return PlantFault{error.what(), "parameters that can be built are expected"};
  }
  if (std::string why = plant::cannot_hold(dock.crane, dock.crane.rated_load); !why.empty())
    return PlantFault{std::move(why), "a smaller rated_load_kg or stronger drives are expected"};
  if (std::string why = plant::cannot_hold(dock.crane, container_mass); !why.empty())
    return PlantFault{std::move(why), "a lighter container or stronger drives are expected", true};
  if (container_mass > dock.crane.rated_load)
    return PlantFault{
        fmt::format(
            "{:g} kg is more than the crane's rated load of {:g} kg, though its hoist would hold them with {:.0f} N m",
            container_mass, dock.crane.rated_load, plant::hoist_holding_torque(dock.crane, container_mass)),
        "a lighter container or a larger rated_load_kg is expected", true};
  return std::nullopt;
}

}  // namespace cmrc
