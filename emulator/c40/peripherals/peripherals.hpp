#pragma once
/// The parts of the chip around the processor core: its registers in memory, the events of the timers, the flags that
/// timers, DMA and pins raise, and the next event of all these.
#include <cstddef>

#include "c40/chip/chip_pins.hpp"
#include "c40/peripherals/dma.hpp"
#include "c40/peripherals/events.hpp"
#include "c40/values/state.hpp"

namespace c40 {

class Peripherals {
 public:
  /// GMICR and LMICR.
  static constexpr Address global_interface = peripheral_base + 0x00, local_interface = peripheral_base + 0x04;

  Peripherals(State& state, Dma& dma, Pins& pins, const PeripheralNotifier& tell)
      : state_(state), dma_(dma), pins_(pins), tell_(tell) {}

  /// The value of a register on the chip in cycle `at`. False if there is no such register at the address, or the FIFO
  /// is empty.
  bool read(Address address, Cycles at, Word& value) const;
  /// False if there is no such register at the address, or it belongs to a port: an access to a port can wait.
  bool write(Address address, Word value, Cycles at);
  /// GMICR or LMICR was written, and memory does not use the new value yet.
  bool interface_changed() const { return interface_changed_; }
  void interface_settled() { interface_changed_ = false; }

  /// An event: goes to the DMA if a channel that is not in reset selects it in DIE (c40-hardware.md 3.8), else sets a
  /// flag of IIF.
  void raise(Word flag);
  /// The outside drives a pin from cycle `at` on.
  void set_pin(Pin pin, bool level, Cycles at);
  bool reacts_to(Pin pin) const;
  /// The timer's events go to the DMA; a halted channel only keeps them.
  bool timer_drives_dma(std::size_t timer) const;
  /// An instruction, or the outside, may have changed what the chip drives.
  void pins_changed();

  /// Executes all events up to cycle `at`.
  void advance_to(Cycles at);
  /// Before this cycle, no peripheral changes by itself in a way that the processor, or a listener of pins, could see.
  Cycles next_event() const { return next_event_; }
  /// Within one cycle, the end of a DMA block comes before the timers' events and the processor's access to a port.
  void end_dma_block(Cycles at);

  /// A DMA channel is started, or one of its accesses or the end of its block is under way.
  bool dma_active() const { return dma_active_; }
  bool dma_busy() const { return dma_active_ && dma_.busy(); }
  bool dma_waits() const { return dma_active_ && !dma_.busy(); }
  /// To be called after anything that may have started or stopped a channel.
  void watch_dma();
  /// To be called after a change of the state from outside: computes derived values again.
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
