#include "machine/boards/board_timer.hpp"

namespace machine {

using c40::Address;
using c40::Cycles;
using c40::Word;

void Timer::advance_to(Cycles now) {
  const Cycles first = expires();
  if (first > now) return;
  if ((status_ & expired) != 0) status_ |= overrun;
  status_ |= expired;
  since_ = first;
  count_ = (control_ & once) != 0 ? 0 : reload_;
  if (count_ == 0) control_ &= ~runs;
  if (expires() > now) return;
  const Cycles period = count_cycles_ * static_cast<Cycles>(count_);
  since_ += (now - since_) / period * period;
  status_ |= overrun;
}

void Timer::leave_zero() {
  if ((control_ & runs) != 0 && count_ == 0) count_ = reload_;
  if (count_ == 0) control_ &= ~runs;
}

Word Timer::read(Address offset, Cycles now) {
  switch (offset) {
    case 0: return count(now);
    case 1: return reload_;
    case 2: return control_;
    default: return status_;
  }
}

void Timer::write(Address offset, Word value, Cycles now) {
  switch (offset) {
    case 0:
      count_ = value, since_ = now;
      leave_zero();
      break;
    case 1: reload_ = value; break;
    case 2:
      count_ = count(now);
      // The first count after a start is a whole one. The counts of a timer that runs already are not delayed.
      since_ = (control_ & runs) == 0 ? now : now - (now - since_) % count_cycles_;
      control_ = value & (runs | interrupt | once);
      leave_zero();
      break;
    default: status_ &= ~value;
  }
}

void Timer::list_state(state::Visitor& list) {
  list("since", since_);
  list("count", count_);
  list("reload", reload_);
  list("control", control_);
  list("status", status_);
}

}  // namespace machine
