#pragma once
// The registers of bus B: one row for each, or for several equal ones. A new register is a row here and its offset in
// c40_programs/include/devices.inc.
#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "machine/system/bus_topology.hpp"
#include "machine/time/time.hpp"
#include "plant/parameters/config.hpp"

namespace plant {
class Dock;
}
namespace toolchain {
struct Image;
}

namespace machine {

using Word = std::uint32_t;

/// The sources of the registers' values: the dock, and values that the devices' cards keep.
struct DeviceConnections {
  /// A bit of one drive. The register has this bit of all drives, that of channel 0 at `place`.
  struct Bit {
    std::uint32_t of_drive;
    Word place;
  };
  /// An AGV unit stores two of its registers until the third is written; then all three take effect.
  struct AgvCommand {
    std::int32_t speed = 0;
    std::int32_t front = 0;
  };

  /// \throws std::out_of_range with the name of a symbol that the program does not define
  DeviceConnections(plant::Dock& dock, const toolchain::Image& program);

  plant::Dock& dock;
  std::array<int, plant::joint_count> joints;  ///< the joint of each channel of the drives and encoders
  std::array<Bit, 4> status_bits, trip_bits;
  std::vector<AgvCommand> commands;  ///< by AGV
};

/// The place of one register among equal ones.
struct DevicePlace {
  std::uint8_t index = 0;  ///< joint, sample or AGV
  std::uint8_t ray = 0;
};

/// How often a register exists.
enum class Repeated : std::uint8_t {
  once,
  channel,  ///< by channel of the drives, one after the other
  sample,   ///< by sample of the bay scanner's profile, one after the other
  agv,      ///< in each AGV's unit
  range,    ///< in each AGV's range sensor
  ray,      ///< in each AGV's range sensor, by ray, one after the other
};

struct DeviceRegister {
  std::string_view name;  ///< symbol of its offset: of the first one, or within the AGV's unit or range sensor
  DeviceGroup group;
  Repeated repeated;
  Word (*read)(const DeviceConnections&, DevicePlace, Time);         ///< null: cannot be read
  void (*write)(DeviceConnections&, DevicePlace, Word value, Time);  ///< null: cannot be written
  bool (*fitted)(const plant::Dock&) = nullptr;                      ///< null: in every dock
};
std::span<const DeviceRegister> device_registers();

/// Every symbol of devices.inc that a program has to define.
std::vector<std::string_view> device_symbols();

/// One register, at its offset of window B.
struct PlacedRegister {
  const DeviceRegister* row;
  Offset offset;
  unsigned index, ray;  ///< as in DevicePlace
};
/// The registers of this dock that the program knows.
std::vector<PlacedRegister> placed_registers(const DeviceConnections& cards, const toolchain::Image& program);

}  // namespace machine
