#pragma once
/// A stub of the VMEbus interface controller VIC068A (VTC, later Cypress), and of the address space behind it.
///
/// The registers hold the values written to them, 8 bits each, at the places and with the read-only fields of Wind
/// River's vic068.h (VxWorks 5.1, 1992; public): register n at byte address 4n + 3, n = 0 to 38h. An access to the VME
/// space meets no module. With answer "bus error" the access ends after the device's waits, a read gets FFFFFFFFh, and
/// the named VIC records a VMEbus time-out in BESR (bits 4 and 5). The VIC's pin stays low until the program writes 0
/// to both bits.
///
/// Inaccuracies: actions that a register starts are not modelled (block transfers, interrupts on the VMEbus, the timer
/// of SS0CR0, a system reset), nor are interrupts of other devices passed on. Values after reset are 0 except ICR5; the
/// header does not give them. A C40 has no pin for bus errors; how a board reports them is a property of the board. The
/// pin is a choice of this model; so is clearing BESR by writing to it.
#include <array>

#include "machine/board_device.hpp"

namespace machine {

class Vic068a final : public BoardDevice, public BusErrorStatus {
 public:
  static constexpr c40::Address registers = 0x39;

  explicit Vic068a(const DeviceDescription& described) : shift_(described.shift) {
    held_[icr5] = static_cast<std::uint8_t>(described.value);
  }
  c40::Word read(c40::Address number, c40::Cycles now) override;
  void write(c40::Address number, c40::Word value, c40::Cycles now) override;
  bool interrupts() const override { return (held_[besr] & (vme_timeout | vme_error)) != 0; }
  void note_timeout(bool /*write*/) override { held_[besr] |= vme_timeout | vme_error; }
  void list_state(state::Visitor& list) override { list("held", held_); }

 private:
  static constexpr std::size_t icr5 = 0x1D, besr = 0x2E;
  static constexpr std::uint8_t vme_timeout = 0x10, vme_error = 0x20;

  unsigned shift_;
  std::array<std::uint8_t, registers> held_{};
};

class VmeSpace final : public BoardDevice {
 public:
  explicit VmeSpace(const DeviceDescription& described) : bus_error_(described.bus_error) {}
  c40::Word read(c40::Address, c40::Cycles) override { return note(false), nothing; }
  void write(c40::Address, c40::Word, c40::Cycles) override { note(true); }
  /// The VIC that records bus errors.
  void tell(BusErrorStatus* vic) { vic_ = vic; }
  void list_state(state::Visitor& list) override { list("errors", errors_); }

 private:
  static constexpr c40::Word nothing = 0xFFFFFFFF;  ///< the value on a bus without a driver
  void note(bool write) {
    if (!bus_error_) return;
    ++errors_;
    if (vic_ != nullptr) vic_->note_timeout(write);
  }
  bool bus_error_;
  BusErrorStatus* vic_ = nullptr;
  std::uint64_t errors_ = 0;
};

}  // namespace machine
