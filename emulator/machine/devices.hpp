#pragma once
// The drives, sensors and AGV units of the dock on their buses, behind the registers of machine/device_registers.hpp.
// Offsets are those of window B.
#include <array>
#include <cstdint>
#include <vector>

#include "bus_model/bus.hpp"
#include "machine/bus_topology.hpp"
#include "machine/device_registers.hpp"
#include "machine/shared_memory.hpp"
#include "machine/time.hpp"

namespace machine {

class Devices final : public pci::Target {
 public:
  /// The program says at which offsets it knows the registers. \throws std::invalid_argument where two share one,
  /// or its numbers are not the dock's
  Devices(const toolchain::Image& program, plant::Dock& dock, const std::array<Clock, device_groups>& clocks,
          const Fence& fence);

  /// Offsets 0 to size() - 1; not every one has a register.
  Offset size() const { return static_cast<Offset>(registers_.size()); }
  bool answers(Offset offset, bool write) const {
    if (offset >= registers_.size() || registers_[offset].row == none) return false;
    const DeviceRegister& row = row_of(registers_[offset]);
    return write ? row.write != nullptr : row.read != nullptr;
  }
  /// A stretch of offsets whose registers belong together; a hole belongs to what stands before it.
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
    std::uint8_t row = none;  // of device_registers()
    DevicePlace place{};
  };

  void define(const PlacedRegister& one);
  const DeviceRegister& row_of(const Register& one) const { return rows_[one.row]; }
  Time instant(const DeviceRegister& row, const pci::Access& access) const {
    return clocks_[static_cast<std::size_t>(row.group)].at(access.clock);
  }

  std::array<Clock, device_groups> clocks_;  // of the bus on which each group stands
  const Fence& fence_;
  DeviceConnections cards_;
  std::span<const DeviceRegister> rows_ = device_registers();
  std::vector<Register> registers_;
};

/// A stretch of the devices as a target of its bus, where it begins at offset 0.
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
