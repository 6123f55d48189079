// Whether a chip of a network goes round a loop that nothing will end.
#include <algorithm>

#include "machine/networks/network_parts.hpp"

namespace machine {

using c40::Address;

/// Others can change what is read there.
bool Network::Node::is_shared(Address address) const {
  if (network.memory_of(*this, address) != nullptr) return true;
  return c40::is_port_register(address) &&
         network.neighbour(*this, c40::port_access(address, false, 0, 0).port).has_value();
}

void Network::Node::begin_patience() {
  Patience& p = patience;
  p.loop.reset();
  p.since = first_cycle(network.happened_), p.length = Patience::first, p.news = network.news_;
  if (!p.looking) return;
  p.looking.reset();
  chip.set_trace(trace);
}

/// Looks from time to time whether the chip goes round a loop.
void Network::Node::look_for_loop() {
  Patience& p = patience;
  if (p.is_private) return;
  const auto alone = [&] { return status == ChipStatus::running || (status == ChipStatus::waiting && is_ready()); };
  if (p.news != network.news_ || !alone()) {
    begin_patience();
  } else if (!p.loop && chip.cycle() >= p.next_look()) {
    if (!p.looking) {
      p.looking.emplace(chip, trace);
      chip.set_trace(&*p.looking);
    } else {
      if (!chip.dma_busy() && chip.next_event() == never_cycle) p.loop = p.looking->loop();
      const auto at_device = [&](Address a) { return devices != nullptr && devices->has(a); };
      if (p.loop && devices != nullptr && devices->continues() && std::ranges::any_of(p.loop->reads, at_device))
        p.loop.reset();
      p.found = clock.at(chip.cycle());
      p.is_private = p.loop && !follows() &&
                     std::none_of(p.loop->reads.begin(), p.loop->reads.end(), [&](Address a) { return is_shared(a); });
      p.looking.reset();
      chip.set_trace(trace);
      p.length *= Patience::growth;
    }
  }
}

}  // namespace machine
