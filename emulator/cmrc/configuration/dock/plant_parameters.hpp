#pragma once
// The plant's parameters as keys of the configuration: [slewing] and [gantry], their drives, [agv] and [landing]
// (docs/configuration.md). Each default is written once, in plant/parameters/config.hpp; the DSPs' programs get their
// values from the same dock (plant_constants.hpp).
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "plant/parameters/basics.hpp"

namespace plant {
struct DockConfig;
}

namespace cmrc {

/// One parameter: one key.
struct PlantParameter {
  std::string name;  ///< with dots
  std::string unit;
  double scale;             ///< the key's unit in units of the plant
  double minimum, maximum;  ///< in the key's unit
  std::string meaning, source;
  std::optional<plant::CraneKind> machine;  ///< the crane to which the parameter belongs; none: every dock has it
  std::function<double&(plant::DockConfig&)> at;
};
std::span<const PlantParameter> plant_parameters();

/// Every parameter's default, in its key's unit.
const std::vector<double>& plant_defaults();
/// Puts the values that differ from their default, and belong to the dock's crane, into the dock.
void place_plant_parameters(plant::DockConfig& dock, const std::vector<double>& values);
/// What is wrong with the crane and the vehicles together; empty: nothing.
/// \param container_mass kg, the crane's load
struct PlantFault {
  std::string what, right;
  bool of_load = false;  ///< the container's mass is too large
};
std::optional<PlantFault> plant_fault(plant::CraneKind machine, const std::vector<double>& values,
                                      double container_mass);

}  // namespace cmrc
