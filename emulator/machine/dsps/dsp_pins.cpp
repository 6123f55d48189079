// The pins of a DSP board that nets connect to pins of other boards.
#include <algorithm>

#include "machine/dsps/dsp.hpp"

namespace machine {

void Dsp::join(Net& net) {
  const auto take = [&](const std::vector<ChipPin>& pins, std::vector<Net*>& nets, unsigned& mask) {
    for (const ChipPin& pin : pins) {
      if (pin.chip != slot_) continue;
      if (nets.empty() || nets.back() != &net) nets.push_back(&net);
      mask |= 1u << static_cast<unsigned>(pin.pin);
    }
  };
  take(net.description().drivers, nets_out_, outputs_);
  take(net.description().receivers, nets_in_, inputs_);
  chip_.watch_pins(this, outputs_, inputs_);
}

void Dsp::driven(c40::Pin pin, c40::Drive drive, c40::Cycles at) {
  const ChipPin mine{slot_, pin};
  const auto driven_by_it = [&](const Net* net) {
    return std::ranges::find(net->description().drivers, mine) != net->description().drivers.end();
  };
  (*std::ranges::find_if(nets_out_, driven_by_it))
      ->driven(mine, drive, std::max(context_.scheduler.now(), clock_.at(at)));
}

/// Changes by its timers of pins that drive nets, while an access is under way and the chip's own time does not
/// advance.
Time Dsp::next_pin_event() const {
  if (nets_out_.empty() || !in_access()) return never;
  const c40::Cycles event = chip_.next_event();
  return event == std::numeric_limits<c40::Cycles>::max() ? never : clock_.at(event);
}

Time Dsp::nets_reach() const {
  Time reach = never;
  for (const Net* net : nets_in_) reach = std::min(reach, net->reaches(slot_));
  return reach;
}

Time Dsp::drives_from() const {
  if (state_ == State::running) return clock_.at(chip_.settled());
  return std::min(next_pin_event(), context_.scheduler.earliest());
}

// RESET going low is a reset. An edge during an access is seen when the instruction has ended; a timer counts it at
// once.
void Dsp::pin_changes(c40::Pin pin, bool level, Time now) {
  if (pin == c40::Pin::reset) {
    if (!level) reset(now);
    return;
  }
  if (in_access() && !c40::is_timer_pin(pin)) {
    pins_waiting_.push_back({pin, level});
    return;
  }
  const bool between = caught_up(now);
  chip_.set_pin(pin, level, std::max(chip_.settled(), clock_.tick_at_or_after(now)));
  if (between && !chip_.dormant()) {
    state_ = State::running;
    own_next_ = clock_.at(chip_.cycle());
  }
  set_next();
}

}  // namespace machine
