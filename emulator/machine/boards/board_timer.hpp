#pragma once
/// A timer that counts down.
///
/// Words: +0 count, +1 reload, +2 control (bit 0 run, bit 1 interrupt, bit 2 once), +3 status (bit 0 expired, bit 1
/// expired again before bit 0 was cleared; writing a 1 clears a bit). The timer expires when the count reaches 0, and
/// then starts again at `reload`; if `reload` is 0, or with `once`, it stops. A timer that is started at 0, or that the
/// program sets to 0 while it runs, begins at `reload`, too, and does not expire.
#include "machine/boards/board_device.hpp"

namespace machine {

class Timer final : public BoardDevice {
 public:
  static constexpr c40::Address registers = 4;

  explicit Timer(const DeviceDescription& described) : count_cycles_(described.count_cycles) {}

  c40::Word read(c40::Address offset, c40::Cycles now) override;
  void write(c40::Address offset, c40::Word value, c40::Cycles now) override;
  void advance_to(c40::Cycles now) override;
  c40::Cycles next_event() const override {
    return (control_ & interrupt) != 0 && (status_ & expired) == 0 ? expires() : never_cycle;
  }
  bool continues() const override { return expires() != never_cycle; }
  bool interrupts() const override { return (control_ & interrupt) != 0 && (status_ & expired) != 0; }
  void list_state(state::Visitor& list) override;

 private:
  /// A timer does not run at 0: it begins at `reload`, or stops.
  void leave_zero();

  static constexpr c40::Word runs = 1, interrupt = 2, once = 4, expired = 1, overrun = 2;

  c40::Cycles expires() const {
    return (control_ & runs) != 0 && count_ != 0 ? since_ + count_cycles_ * static_cast<c40::Cycles>(count_)
                                                 : never_cycle;
  }
  /// The count in a cycle before the timer expires.
  c40::Word count(c40::Cycles now) const {
    return (control_ & runs) == 0 ? count_ : count_ - static_cast<c40::Word>((now - since_) / count_cycles_);
  }

  c40::Cycles count_cycles_;
  c40::Cycles since_ = 0;  ///< the cycle in which the count was `count_`
  c40::Word count_ = 0, reload_ = 0, control_ = 0, status_ = 0;
};

}  // namespace machine
