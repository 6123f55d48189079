#pragma once
// The drives, sensors and AGV units of the dock behind the registers of c40_programs/include/devices.inc. Offsets are those of
// window B.
#include <array>
#include <cstdint>
#include <vector>

#include "bus_model/bus.hpp"
#include "machine/shared_memory.hpp"
#include "machine/symbols.hpp"
#include "machine/time.hpp"
#include "machine/topology.hpp"

namespace plant {
class Dock;
}

namespace machine {

class Devices final : public pci::Target {
 public:
  Devices(const Symbols& symbols, plant::Dock& dock, const std::array<Clock, device_groups>& clocks, const Fence& fence);

  /// Offsets 0 to size() - 1; not every one has a register.
  Offset size() const { return static_cast<Offset>(registers_.size()); }
  bool answers(Offset offset, bool write) const {
    return offset < registers_.size() && (write ? registers_[offset].writable() : registers_[offset].readable());
  }
  /// A stretch of offsets whose registers belong together; a hole belongs to what stands before it.
  struct Stretch {
    DeviceGroup group;
    Offset first;
    Offset end;
  };
  std::vector<Stretch> stretches() const;
  void append_state(std::vector<std::uint64_t>& words) const;
  void list_state(state::Visitor& list) { list("commands", commands_); }

  pci::Answer answer(pci::Address offset, unsigned words, bool write, const pci::Access& access) override;
  Word read(pci::Address offset, const pci::Access& access) override;
  void write(pci::Address offset, Word value, const pci::Access& access) override;

 private:
  enum class Kind : std::uint8_t {
    none,
    drive_torque,
    drive_enable,
    spreader_command,
    scan_row,
    agv_period,
    agv_speed_command,
    agv_front_command,
    agv_rear_command,  // written
    encoder,
    sway,
    second_sway,
    load_cell,
    wind_mean,
    drive_status,
    drive_speed,
    drive_trip,
    drive_heat,
    spreader_status,
    scan_rows,
    scan_y,
    scan_x0,
    scan_dx,
    scan_deck,
    scan_profile,
    agv_x,
    agv_y,
    agv_heading,
    agv_speed,
    agv_status,
    range_count,
    range_first,
    range_step,
    range_mount,
    range_scan,
    range_way,
    range_ray,  // read
  };
  struct Register {
    Kind kind = Kind::none;
    std::uint8_t index = 0;  // joint, axis, sample or AGV
    std::uint8_t ray = 0;
    DeviceGroup group() const;
    bool writable() const { return kind >= Kind::drive_torque && kind <= Kind::agv_rear_command; }
    bool readable() const { return kind >= Kind::encoder; }
  };
  struct AgvCommand {
    std::int32_t speed = 0;
    std::int32_t front = 0;
  };

  void define(Offset offset, Kind kind, unsigned index = 0, unsigned ray = 0);

  std::uint32_t joints_enabled(Word channels) const;
  Word drive_status(Time t) const;
  Word drive_trip(Time t) const;

  plant::Dock& dock_;
  std::array<Clock, device_groups> clocks_;  // of the bus on which each group stands
  const Fence& fence_;
  std::array<int, 5> channels_;  // the joint behind each of the drives' and encoders' channels
  struct StatusBit {
    std::uint32_t plant;  // as the dock says it
    Word place;           // of channel 0, in the register
  };
  std::array<StatusBit, 4> status_bits_{}, trip_bits_{};
  Word collected(const std::array<StatusBit, 4>& places, std::uint32_t (plant::Dock::*say)(int, Time), Time t) const;
  std::vector<Register> registers_;
  std::vector<AgvCommand> commands_;
};

}  // namespace machine
