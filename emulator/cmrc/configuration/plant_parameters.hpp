#pragma once
// The plant's parameters as keys of the configuration: [slewing] and [gantry], their drives, [agv] and [landing]
// (docs/configuration.md). Each value is written once, in plant/parameters/config.hpp; DSPs' programs get theirs from
// the same dock (plant_constants.hpp).
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "plant/parameters/config.hpp"

namespace cmrc {

/// One parameter: one key.
struct PlantParameter {
  std::string name;  ///< dotted
  std::string unit;
  double scale;             ///< of the key's unit, in the plant's
  double minimum, maximum;  ///< in the key's unit
  std::string meaning, source;
  std::optional<plant::CraneKind> machine;  ///< whose it is; none: of every dock
  std::function<double&(plant::DockConfig&)> at;
};
std::span<const PlantParameter> plant_parameters();

/// Every parameter's default, in its key's unit.
const std::vector<double>& plant_defaults();
/// Puts those that differ from their default, and are of the dock's machine, into the dock.
void place_plant_parameters(plant::DockConfig& dock, const std::vector<double>& values);
/// What is wrong with the crane and the vehicles of that machine, taken together; empty: nothing.
/// \param container_mass kg, what the crane is to carry
struct PlantFault {
  std::string what, right;
  bool of_load = false;  ///< the container's mass is what does not fit
};
std::optional<PlantFault> plant_fault(plant::CraneKind machine, const std::vector<double>& values,
                                      double container_mass);

}  // namespace cmrc
