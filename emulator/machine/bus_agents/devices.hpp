#pragma once
// The drives, sensors and AGV units of the dock on their buses, behind the registers of
// machine/bus_agents/device_registers.hpp. Offsets are those of window B.
#include <array>
#include <cstdint>
#include <vector>

#include "bus_model/bus.hpp"
#include "machine/bus_agents/device_registers.hpp"
#include "machine/bus_agents/shared_memory.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/time/time.hpp"

namespace machine {

class Devices final : public pci::Target {
 public:
  /// The program gives the offsets of the registers. \throws std::invalid_argument if two registers have one offset, or
  /// the program's numbers differ from the dock's
  Devices(const toolchain::Image& program, plant::Dock& dock, const std::array<Clock, device_groups>& clocks,
          const Fence& fence);

  /// Offsets 0 to size() - 1; not every one has a register.
  Offset size() const { return static_cast<Offset>(registers_.size()); }
  bool answers(Offset offset, bool write) const {
    if (offset >= registers_.size() || registers_[offset].row == none) return false;
    const DeviceRegister& row = row_of(registers_[offset]);
    return write ? row.write != nullptr : row.read != nullptr;
  }
  /// A range of offsets whose registers belong together; a gap belongs to the registers before it.
  struct RegisterRange {
    DeviceGroup group;
    Offset first;
    Offset end;
  };
  std::vector<RegisterRange> ranges() const;
  void append_state(std::vector<std::uint64_t>& words) const;
  void list_state(state::Visitor& list) { list("commands", cards_.commands); }

  pci::Answer answer(pci::Address offset, unsigned words, bool write, const pci::Access& access) override;
  Word read(pci::Address offset, const pci::Access& access) override;
  void write(pci::Address offset, Word value, const pci::Access& access) override;

 private:
  static constexpr std::uint8_t none = 0xFF;
  struct Register {
    std::uint8_t row = none;  // index in device_registers()
    DevicePlace place{};
  };

  void define(const PlacedRegister& one);
  const DeviceRegister& row_of(const Register& one) const { return rows_[one.row]; }
  Time instant(const DeviceRegister& row, const pci::Access& access) const {
    return clocks_[static_cast<std::size_t>(row.group)].at(access.clock);
  }

  std::array<Clock, device_groups> clocks_;  // of the bus of each group
  const Fence& fence_;
  DeviceConnections cards_;
  std::span<const DeviceRegister> rows_ = device_registers();
  std::vector<Register> registers_;
};

/// A range of the devices as a target of its bus, which begins at offset 0 there.
class DeviceWindow final : public pci::Target {
 public:
  DeviceWindow(Devices& devices, Offset first) : devices_{devices}, first_{first} {}
  pci::Answer answer(pci::Address offset, unsigned words, bool write, const pci::Access& access) override {
    return devices_.answer(first_ + offset, words, write, access);
  }
  Word read(pci::Address offset, const pci::Access& access) override { return devices_.read(first_ + offset, access); }
  void write(pci::Address offset, Word value, const pci::Access& access) override {
    devices_.write(first_ + offset, value, access);
  }

 private:
  Devices& devices_;
  Offset first_;
};

}  // namespace machine
