#pragma once
// The numbers among the parameters of crane, vehicles and landing that a user may set, one row each. Keys of the
// configuration, their checks and pages (emulator/cmrc/configuration/dock/plant_parameters.cpp), and the members of the
// Python classes (python/bindings/plant/parameters.cpp) follow from the rows. The defaults are in
// plant/parameters/config.hpp.
#include <cstdint>
#include <span>
#include <string_view>

#include "plant/parameters/config.hpp"

namespace plant {

/// The cranes that have a parameter, or the joints whose drive has it.
enum class Where : std::uint8_t { everywhere, slewing, gantry, turning, sliding };

template <class P>
struct ParameterRow {
  std::string_view member;  ///< name in C++ and in Python
  double P::* at;
  std::string_view key;     ///< last part of the configuration's key
  std::string_view unit;    ///< of the key
  double minimum, maximum;  ///< in the key's unit
  std::string_view meaning, source;
  Where where = Where::everywhere;
  double scale = 1.0;  ///< the key's unit in the member's unit
};

std::span<const ParameterRow<CraneParameters>> crane_rows();
std::span<const ParameterRow<Portal>> portal_rows();
std::span<const ParameterRow<DriveParameters>> drive_rows();
std::span<const ParameterRow<AgvParameters>> agv_rows();
std::span<const ParameterRow<LandingParameters>> landing_rows();

}  // namespace plant
