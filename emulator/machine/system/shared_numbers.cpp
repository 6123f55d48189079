#include "machine/system/shared_numbers.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <string_view>

#include "plant/parameters/config.hpp"
#include "plant/parameters/device_codes.hpp"
#include "toolchain/objects/image.hpp"

namespace machine {
namespace {

struct Shared {
  std::string_view symbol;
  std::uint32_t of_dock;
};
constexpr Shared numbers[] = {
    {"DRIVE_COUNT", plant::joint_count},
    {"ENCODER_BITS", plant::encoder_bits},
    {"SWAY_BITS", plant::sway_bits},
    {"SPREADER_CORNERS", plant::spreader_corners},
    {"SPREADER_LOCKED", plant::spreader_locked},
    {"SPREADER_OPEN", plant::spreader_open},
    {"SCAN_COUNT", plant::scan_count},
    {"AGV_WAITING", plant::agv_waiting},
    {"AGV_STANDING", plant::agv_standing},
    {"AGV_LOADED", plant::agv_loaded},
    {"AGV_RAN_DRY", plant::agv_ran_dry},
    {"AGV_BUMPER", plant::agv_bumper},
    {"RANGE_RAYS", plant::range_rays},
    {"RANGE_MOST", plant::range_most},
};

}  // namespace

std::optional<std::string> contradiction(const toolchain::Image& program) {
  std::string wrong;
  for (const auto& [symbol, of_dock] : numbers) {
    const auto found = program.symbols.find(symbol);
    if (found == program.symbols.end() || found->second == of_dock) continue;
    wrong += fmt::format("{}{} is {}, but the dock's devices have {}", wrong.empty() ? "" : "; ", symbol, found->second,
                         of_dock);
  }
  if (wrong.empty()) return std::nullopt;
  return wrong + "; the numbers of devices.inc are expected";
}

}  // namespace machine
