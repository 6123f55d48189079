#pragma once
/// What surrounds the processor core on the chip: its registers in memory, the timers' events, the flags that they, the
/// DMA and the pins raise, and when the next of all that is due.
#include <cstddef>

#include "c40/chip_pins.hpp"
#include "c40/peripherals/dma.hpp"
#include "c40/peripherals/events.hpp"
#include "c40/state.hpp"

namespace c40 {

class Peripherals {
 public:
  /// GMICR and LMICR.
  static constexpr Address global_interface = peripheral_base + 0x00, local_interface = peripheral_base + 0x04;

  Peripherals(State& state, Dma& dma, Pins& pins, const PeripheralNotifier& tell)
      : state_(state), dma_(dma), pins_(pins), tell_(tell) {}

  /// A register on the chip as it stands in cycle `at`; false if nothing of the kind is at the address, or the FIFO is
  /// empty.
  bool read(Address address, Cycles at, Word& value) const;
  /// False if nothing of the kind is at the address, or it is a port's: an access to a port can wait.
  bool write(Address address, Word value, Cycles at);
  /// GMICR or LMICR was written, and memory does not yet follow them.
  bool interface_changed() const { return interface_changed_; }
  void interface_settled() { interface_changed_ = false; }

  /// An event: for the DMA if a started channel selects it in DIE (c40-hardware.md 3.8), else a flag of IIF.
  void raise(Word flag);
  /// The outside drives a pin from cycle `at` on.
  void set_pin(Pin pin, bool level, Cycles at);
  bool heeds(Pin pin) const;
  bool timer_drives_dma(std::size_t timer) const;
  /// An instruction, or who stands outside, may have changed what the chip drives.
  void pins_changed();

  /// All that happens by itself up to cycle `at`.
  void advance_to(Cycles at);
  /// Before it, no peripheral does anything by itself that the processor, or who watches pins, could see.
  Cycles next_event() const { return next_event_; }
  /// In one cycle, a block of the DMA ends before the timers' events and the processor's access to a port.
  void end_dma_block(Cycles at);

  /// A channel of the DMA is started, or an access of it under way.
  bool dma_active() const { return dma_active_; }
  bool dma_busy() const { return dma_active_ && dma_.busy(); }
  bool dma_waits() const { return dma_active_ && !dma_.busy(); }
  /// After whatever may have started or stopped a channel.
  void watch_dma();
  /// After whatever changed the state from outside: finds out anew what follows from it.
  void state_changed();

  void list_state(state::Visitor& list);

 private:
  void timer_event(std::size_t timer, Cycles at);
  void expect();

  State& state_;
  Dma& dma_;
  Pins& pins_;
  const PeripheralNotifier& tell_;
  Cycles next_event_ = 0;
  bool dma_active_ = false;
  bool interface_changed_ = false;
};

}  // namespace c40
