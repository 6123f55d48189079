#pragma once
/// The parts of the chip around the processor core: its registers in memory, the events of the timers, the flags that
/// timers, DMA and pins raise, and the next event of all these.
#include <cstddef>
#include <limits>
#include <vector>

#include "c40/chip/chip_pins.hpp"
#include "c40/chip/state.hpp"
#include "c40/peripherals/dma.hpp"
#include "c40/peripherals/events.hpp"

namespace c40 {

/// What the processor, a timer or a pin does to the DMA in a cycle that the DMA has not reached: first it does what
/// begins before.
struct DmaInput {
  enum class Kind : std::uint8_t { event, write, interrupt_enable } kind = Kind::event;
  Cycles at = 0;
  Word value = 0;       ///< the event's flag of IIF; the word that is written; DIE before it was written
  Address address = 0;  ///< of a write
};

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
  /// The same by the processor: in cycle `at` the DMA has done what begins before.
  bool write_by_processor(Address address, Word value, Cycles at);
  /// The processor has changed DIE, which was `before`, in cycle `at`.
  void interrupt_enable_written(Word before, Cycles at);
  /// GMICR or LMICR was written, and memory does not use the new value yet.
  bool interface_changed() const { return interface_changed_; }
  void interface_settled() { interface_changed_ = false; }

  /// An event: goes to the DMA if a channel that is not in reset selects it in DIE (c40-hardware.md 3.8), else sets a
  /// flag of IIF.
  void raise(Word flag, Cycles at);
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
  bool dma_busy() const { return dma_active_ && (dma_.busy() || has_dma_input()); }
  bool dma_waits() const { return dma_active_ && !dma_busy(); }
  bool has_dma_input() const { return !dma_inputs_.empty(); }
  /// The cycle of the next input; the greatest number if there is none.
  Cycles next_dma_input() const { return has_dma_input() ? dma_inputs_.front().at : never; }
  /// Gives the DMA its inputs up to cycle `at`, which it has reached.
  void give_dma_inputs(Cycles at);
  /// Gives it all of them: what comes next is from outside.
  void give_all_dma_inputs() { give_dma_inputs(never); }
  void delay_dma_inputs(Cycles cycles);
  /// DIE, as the DMA sees it.
  Word dma_interrupt_enable() const {
    return has_dma_input() ? dma_interrupt_enable_before() : state_.core.r[reg::DIE];
  }
  /// To be called after anything that may have started or stopped a channel.
  void watch_dma();
  /// To be called after a change of the state from outside: computes derived values again.
  void state_changed();
  void was_reset();

  void list_state(state::Visitor& list);

 private:
  static constexpr Cycles never = std::numeric_limits<Cycles>::max();
  void timer_event(std::size_t timer, Cycles at);
  void expect();
  bool dma_is_behind(Cycles at) const {
    return dma_active_ && state_.dma.now < at && (has_dma_input() || dma_.busy() || dma_.ends());
  }
  void note(const DmaInput& input);
  void give(const DmaInput& input);
  void set_flag(Word flag);
  Word dma_interrupt_enable_before() const;

  State& state_;
  Dma& dma_;
  Pins& pins_;
  const PeripheralNotifier& tell_;
  Cycles next_event_ = 0;
  bool dma_active_ = false;
  bool interface_changed_ = false;
  std::vector<DmaInput> dma_inputs_;  ///< by their cycles
};

}  // namespace c40
