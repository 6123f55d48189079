// When a chip of a network has a turn, and how far it may go before others can reach it.
#include <algorithm>
#include <cassert>
#include <tuple>

#include "machine/chips/asleep.hpp"
#include "machine/networks/network_parts.hpp"

namespace machine {

using c40::Cycles;

Time Network::Node::next() const {
  switch (status) {
    case ChipStatus::running:
      if (patience.is_private) return never;
      return follows() ? now() : std::max(clock.at(chip.cycle()), dma_answered);
    case ChipStatus::waiting: {
      if (dma_awaits_answer()) return access_time();
      if (!chip.dma_active()) return std::min(access_time(), next_pin_event());
      const Time next = std::min({access_time(), own_event(), next_pin_event()});
      return follows() ? std::min(next, now()) : next;
    }
    case ChipStatus::sleeping: return std::min(own_event(), next_pin_event());
    default: return next_pin_event();
  }
}

/// What its timers do at pins that drive nets, while no instruction does anything.
Time Network::Node::next_pin_event() const {
  if (nets_out.empty() || chip.halted()) return never;
  const Cycles event = chip.next_event();
  return event == never_cycle ? never : clock.at(event);
}

bool Network::Node::only_drives_unheard() const {
  if (std::ranges::any_of(nets_out, &Net::has_listener)) return false;
  return own_event() == never && access_time() == never && !follows();
}

/// A chip that follows its ports runs no further than anything could reach it. Whether a chip goes round a loop is
/// looked at in a certain cycle, wherever the chip has stopped before.
Time Network::Node::horizon() const { return follows() ? horizon_of_follower() : horizon_on_its_own(); }

Time Network::Node::horizon_on_its_own() const {
  // A chip that polls runs to where others could see it, wherever it has stopped before.
  const Time limit =
      patience.loop ? network.scheduler_.limit() : std::min(network.scheduler_.limit(), network.ends_at_);
  const Cycles action = network.next_action_on(*this);
  return action == never_cycle ? limit : std::min(limit, clock.at(action));
}

Time Network::Node::horizon_of_follower() const {
  const Time outside = std::min(
      {network.scheduler_.limit(), network.ends_at_, network.next_action(), next_device_event(), others_reach_it()});
  if (status != ChipStatus::running) return std::min(outside, access_time());
  // In a loop it stays behind the network's end, of which only so much is known: whatever has not come to rest does
  // something before.
  if (patience.loop) return std::min(outside, network.at_rest_since(network.scheduler_.earliest_of_others(*this)));
  // run_to lets it begin an instruction in the last cycle: in the one before that in which it is looked at
  const Cycles look = std::max(patience.next_look(), chip.cycle() + 1);
  return std::min(outside, clock.at(chip.idle() ? look : look - 1));
}

/// By what is on its links and nets, or by what any chip may do from now on. Where all others wait, that is an answer
/// to what it does itself; and that on a link stops it. At a pin to which another chip listens, an instruction may do
/// something at any time, so that it stays near. In a loop, too: the network's end may be near
/// (Network::at_rest_since).
Time Network::Node::others_reach_it() const {
  const bool others_wait = !patience.loop && std::ranges::none_of(nets_out, &Net::has_listener) &&
                           network.scheduler_.earliest_of_others(*this) == never;
  const Time first = others_wait ? never : network.scheduler_.earliest(), ahead = lookahead();
  Time reach = first < never - ahead ? first + ahead : never;
  for (const std::size_t link : links) reach = std::min(reach, network.links_[link]->next_event());
  for (const Net* net : nets_in) reach = std::min(reach, net->reaches(number));
  const Cycles last = last_before_devices();
  return last == never_cycle ? reach : std::min(reach, clock.at(last + 1));
}

/// What others do reaches it so much later at the earliest.
Time Network::Node::lookahead() const {
  Time ahead = never;
  for (const std::size_t link : links) ahead = std::min(ahead, network.links_[link]->lookahead());
  return ahead;
}

void Network::Node::act(Time now) {
  network.now_ = now;
  const bool on_its_own = status == ChipStatus::running && !follows();
  if (status == ChipStatus::sleeping)
    bring_to(now, false);
  else if (!on_its_own)
    continue_with_others(now);
  if (next_pin_event() <= now) drive_on(now);
  look_for_loop();
  if (on_its_own || (status == ChipStatus::running && !follows())) run_freely(horizon_on_its_own());
  if (!on_its_own || !network.actions_.empty()) tell_changes();
}

/// It waits, or follows its ports: as far as they are known, or its access.
void Network::Node::continue_with_others(Time now) {
  if (status != ChipStatus::waiting || (chip.dma_active() && !dma_awaits_answer())) {
    const auto stands = std::tuple{chip.settled(), chip.cycle(), status};
    if (own_event() == now || (chip.dma_active() && next_pin_event() == now))
      run_to(std::min(horizon_of_follower(), clock.at(first_cycle(now) + 1)), last_before_devices());
    else if (follows())
      run_to(horizon_of_follower(), last_before_devices());
    if (stands != std::tuple{chip.settled(), chip.cycle(), status}) return;
  }
  if (next_pin_event() <= now && !dma_awaits_answer()) return;
  if (waits_for_port() && is_ready()) {
    const Cycles cycle = std::max(stop.port.cycle, first_cycle(now));
    if (clock.at(cycle) == now) return network.perform_port(*this, cycle);
  } else if (access_time() == now) {
    return waits_for_device() ? network.perform_device(*this) : network.perform_memory(*this);
  }
  assert(next() > now && "a turn that changes nothing");
}

void Network::Node::run_ahead(Time until) {
  if (follows()) {
    run_to(until, last_before_devices());
    look_for_loop();
  } else {
    run_freely(until);
  }
  tell_changes();
}

void Network::Node::tell_changes() {
  for (const std::size_t link : links) network.link_turns_[link]->changed();
  if (!network.actions_.empty()) network.action_turn_->changed();
}

// Nothing outside can do anything to it before it stops by itself, so a loop that it is found in can be left alone.
void Network::Node::run_freely(Time until) {
  const auto may_continue = [&] { return status == ChipStatus::running && !follows() && !patience.is_private; };
  while (may_continue()) {
    run_to(std::min(until, next_look()));
    look_for_loop();
    if (clock.at(chip.cycle()) >= until) return;  // its DMA may still be behind
  }
}

}  // namespace machine
