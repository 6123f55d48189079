// The status of a chip of a network: what it waits for, since when it rests, whether it has ended.
#include <algorithm>

#include "isa/types.hpp"
#include "machine/chips/asleep.hpp"
#include "machine/networks/network_parts.hpp"

namespace machine {

using c40::Cycles;
using c40::StopInfo;
using c40::Word;

/// Of a chip that sleeps: it has something to do.
bool Network::Node::wakes() const { return chip.dma_busy() || chip.interrupt_pending(); }

bool Network::Node::ready() const {
  if (waits_for_port()) return port_is_ready();
  if (waits_for_device()) return true;
  const Memory& memory = *network.memory_of(*this, stop.access.address);
  return !memory.owner || *memory.owner == number;
}

/// When the access that it waits for takes place, as far as can be said.
Time Network::Node::access_time() const {
  if (status != ChipStatus::waiting || !is_ready()) return never;
  const Time free = waits_for_port() ? ready_since
                    : waits_for_device()
                        ? Time{0}
                        : network.memory_of(*this, stop.access.address)->free_for(number, stop.access.address);
  return clock.at(
      std::max(waits_for_port() ? stop.port.cycle : stop.access.cycle, first_cycle(std::max(free, network.now_))));
}

/// What a timer does to a chip that sleeps or waits; an event that nobody listens to is none.
Cycles Network::Node::own_event_cycle() const {
  const bool sleeps = status == ChipStatus::sleeping;
  if (!sleeps && status != ChipStatus::waiting) return never_cycle;
  const Cycles event = chip.dma_active() ? next_dma_tick(chip) : never_cycle;
  return sleeps && can_interrupt(chip) ? std::min(event, next_timer_interrupt(chip)) : event;
}

Time Network::Node::own_event() const {
  if (status != ChipStatus::sleeping && !chip.dma_active()) return never;
  const Cycles event = own_event_cycle();
  return event == never_cycle ? never : clock.at(event);
}

/// When it came to rest, by what it did itself: not how far it has been brought since.
Time Network::Node::at_rest_since() const {
  if (patience.loop) return patience.found;
  switch (status) {
    case ChipStatus::held:
    case ChipStatus::pulled_out: return Time{0};
    case ChipStatus::waiting:
      return clock.at(std::max(waits_for_port() ? stop.port.cycle : stop.access.cycle, chip.dma_done()));
    case ChipStatus::sleeping:
      return clock.at(std::max(chip.idle() ? chip.idle_since() : asleep_since, chip.dma_done()));
    case ChipStatus::fault:
      return clock.at(std::max(chip.cycle(), stop.fault->cycle));  // perhaps of its DMA, while it waited
    case ChipStatus::external_access: return clock.at(std::max(chip.cycle(), stop.access.cycle));
    default: return clock.at(chip.cycle());
  }
}

/// Its processor, and the transfers that a timer paces; a DMA that could do nothing for it may still be armed.
bool Network::Node::has_ended() const {
  switch (status) {
    case ChipStatus::halt:
    case ChipStatus::idle:
    case ChipStatus::until:
    case ChipStatus::fault:
    case ChipStatus::external_access:
    case ChipStatus::pulled_out: return true;
    case ChipStatus::sleeping: return dma_waits() && !sleeps_for_interrupt() && !timer_paces_dma(chip);
    default: return false;
  }
}

/// By a port, a timer or the DMA.
bool Network::Node::sleeps_for_interrupt() const {
  constexpr Word ports = 0x01FFFFFEu;  // of IIE
  return reacts_to_pins() || (can_interrupt(chip) && (awaits_dma(chip) || awaits_timer(chip) ||
                                                      (chip.register_value(isa::Register::IIE) & ports) != 0));
}

bool Network::Node::awaits_dma_forever() const {
  return status == ChipStatus::sleeping && dma_waits() && sleeps_for_interrupt() && awaits_dma(chip);
}

}  // namespace machine
