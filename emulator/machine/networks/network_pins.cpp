// The pins of a chip in a network: what it drives, and to which it listens.
#include <algorithm>

#include "machine/chips/asleep.hpp"
#include "machine/networks/network_parts.hpp"

namespace machine {

using c40::Cycles;

/// The pin could interrupt it, or move its DMA or a timer that does.
bool Network::Node::reacts_to(c40::Pin pin) const {
  return pin != c40::Pin::reset && chip.reacts_to(pin) &&
         (pin == c40::Pin::nmi || chip.dma_active() || can_interrupt(chip));
}

bool Network::Node::reacts_to_pins() const {
  return std::ranges::any_of(pins_in, [&](c40::Pin pin) { return reacts_to(pin); });
}

Time Network::Node::drives_from() const {
  if (status == ChipStatus::running && !patience.is_private) return now();
  if (dma_awaits_answer()) return network.scheduler_.earliest();  // its timers, too, continue only after the answer
  const bool over = has_ended() && nets_in.empty();
  return over ? next_pin_event() : std::min(next_pin_event(), network.scheduler_.earliest());
}

void Network::Node::driven(c40::Pin pin, c40::Drive drive, Cycles at) {
  const auto driven_by_it = [&](const Net* net) {
    return std::ranges::find(net->description().drivers, ChipPin{number, pin}) != net->description().drivers.end();
  };
  (*std::ranges::find_if(nets_out, driven_by_it))->driven({number, pin}, drive, std::max(network.now_, clock.at(at)));
}

bool Network::Node::listens_to(c40::Pin pin) const {
  if (pin == c40::Pin::reset) return status != ChipStatus::pulled_out;
  switch (status) {
    case ChipStatus::running: return true;
    case ChipStatus::waiting: return chip.dma_active() && chip.reacts_to(pin);
    case ChipStatus::sleeping: return reacts_to(pin);
    default: return false;
  }
}

/// While its timers do something at its pins, and no instruction anything.
void Network::Node::drive_on(Time now) {
  if (status == ChipStatus::waiting)
    bring_timers_to(now);
  else if (status != ChipStatus::running && status != ChipStatus::sleeping)
    chip.stand_until(first_cycle(now));
}

void Network::Node::pin_changes(c40::Pin pin, bool level, Time now) {
  if (network.now_ < now) network.now_ = now;
  if (status == ChipStatus::pulled_out) return;
  if (listens_to(pin)) network.something_happened(), network.changed_ = now;
  if (pin == c40::Pin::reset) {
    const auto kind = level ? NetworkAction::Kind::reset : NetworkAction::Kind::hold;
    if (!level || status == ChipStatus::held) network.add({.kind = kind, .time = now, .target = number});
    return;
  }
  if (network.made_) come_to(now);  // the levels at the start are there before any instruction
  chip.set_pin(pin, level, first_cycle(now));
  wake_up();
  changed();
  tell_changes();
}

}  // namespace machine
