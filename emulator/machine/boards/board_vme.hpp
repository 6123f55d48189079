#pragma once
/// The registers and the bus error of the VMEbus interface controller VIC068A (VTC, later Cypress), and the address
/// space behind it.
///
/// The registers hold the values written to them, 8 bits each, at the places and with the read-only fields of Wind
/// River's vic068.h (VxWorks 5.1, 1992; public): register n at byte address 4n + 3, n = 0 to 38h. An access to the VME
/// space meets no module. With answer "bus error" the access ends after the device's waits, a read gets FFFFFFFFh, and
/// the named VIC records a VMEbus time-out in BESR (bits 4 and 5). The VIC's pin stays low until the program writes 0
/// to both bits.
///
/// Inaccuracies: nothing that a register starts happens (block transfers, interrupts on the VMEbus, the timer of
/// SS0CR0, a system reset), nor are interrupts of others handed on. A program that asks for it is reported
/// (not_modelled). Values after reset are 0 except ICR5; the header does not say them. How a board hands the bus error
/// to a C40, which has no pin for it, is the board's own: the pin is a choice of this model, and so is that BESR is
/// cleared by writing it.
#include <array>

#include "machine/boards/board_device.hpp"

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
  std::vector<NotModelled> not_modelled() const override;
  void list_state(state::Visitor& list) override {
    list("held", held_);
    list("asked", asked_);
  }

 private:
  enum class Request : std::uint8_t { interrupts, vme_interrupt, timer, block_transfer, system_reset, count };
  /// What a value asks for in a register.
  static std::optional<Request> request_of(std::size_t number, std::uint8_t value);

  static constexpr std::size_t icr5 = 0x1D, besr = 0x2E;
  static constexpr std::uint8_t vme_timeout = 0x10, vme_error = 0x20;

  unsigned shift_;
  std::array<std::uint8_t, registers> held_{};
  /// For each request the cycle of the first time; never_asked: there was none.
  static constexpr c40::Cycles never_asked = -1;
  std::array<c40::Cycles, static_cast<std::size_t>(Request::count)> asked_ = [] {
    std::array<c40::Cycles, static_cast<std::size_t>(Request::count)> none{};
    none.fill(never_asked);
    return none;
  }();
};

class VmeSpace final : public BoardDevice {
 public:
  explicit VmeSpace(const DeviceDescription& described) : bus_error_(described.bus_error) {}
  c40::Word read(c40::Address, c40::Cycles now) override { return note(false, now), nothing; }
  void write(c40::Address, c40::Word, c40::Cycles now) override { note(true, now); }
  std::vector<NotModelled> not_modelled() const override {
    if (first_ < 0) return {};
    return {{"access to the VMEbus, on which no module is", first_}};
  }
  /// Who notes it.
  void tell(BusErrorStatus* vic) { vic_ = vic; }
  void list_state(state::Visitor& list) override {
    list("errors", errors_);
    list("first", first_);
  }

 private:
  static constexpr c40::Word nothing = 0xFFFFFFFF;  ///< a bus that nobody drives
  void note(bool write, c40::Cycles now) {
    if (first_ < 0) first_ = now;
    if (!bus_error_) return;
    ++errors_;
    if (vic_ != nullptr) vic_->note_timeout(write);
  }
  bool bus_error_;
  BusErrorStatus* vic_ = nullptr;
  std::uint64_t errors_ = 0;
  c40::Cycles first_ = -1;  ///< access
};

}  // namespace machine
