#include "machine/dsps/link_adapter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "machine/bus_agents/shared_memory.hpp"

namespace machine {

namespace {

/// Has the token after reset; the far end does not.
constexpr int near_port = 0;
constexpr int near = 0, far = 1;  // the link's sides
constexpr Offset fifo_words = c40::Fifo::depth;

}  // namespace

LinkAdapter::LinkAdapter(const Symbols& symbols, unsigned slots, Clock bus_clock, Clock port_clock, Client& client)
    : symbols_{symbols}, slots_{slots}, clock_{bus_clock}, port_clock_{port_clock}, client_{client} {
  const Offset end = symbols.link_adapter + slots * symbols.link_words;
  if (symbols.link_adapter != base || end > symbols.link_request || symbols.link_request - base >= size ||
      symbols.link_data + fifo_words > symbols.link_words || symbols.link_port >= c40::port_count)
    throw std::invalid_argument{
        "the DSP program: registers of the link adapter lie at offsets 11000h to 11FFFh of bus A, LINK_REQUEST behind "
        "the slots'"};
}

void LinkAdapter::join(c40::Chip& chip, const PacedClock& clock, bool plugged) {
  Port& port = ports_.emplace_back(static_cast<unsigned>(ports_.size()), client_);
  port.port.reset(near_port);
  port.link.emplace(
      c40::Link::Side{fmt::format("link adapter port {}", port.slot), near_port, &port.port, PacedClock{port_clock_}},
      c40::Link::Side{fmt::format("DSP {} port {}", port.slot, dsp_port()), dsp_port(), &chip.port(dsp_port()), clock});
  port.plugged = plugged;
  if (!plugged) port.link->cut(Time{0});
  port.link->listener_of_events = &port;
}

void LinkAdapter::reset(unsigned slot, Time now) {
  Port& port = ports_.at(slot);
  const c40::Cycles at = port_clock_.tick_at_or_after(now);
  port.link->listener(near).about_to_reset(at);
  port.port.reset(near_port);
  port.link->listener(near).was_reset(port.port, at);
  port.closed = true;
  requests_ &= ~(Word{1} << slot);
}

void LinkAdapter::set_plugged(unsigned slot, bool plugged, Time now) {
  ports_.at(slot).plugged = plugged;
  join(ports_.at(slot), now);
}

void LinkAdapter::set_broken(unsigned slot, bool broken, Time now) {
  ports_.at(slot).broken = broken;
  join(ports_.at(slot), now);
}

void LinkAdapter::join(Port& port, Time now) {
  if (port.plugged && !port.broken)
    port.link->restore(now);
  else
    port.link->cut(now);
  client_.link_changed(port.slot);
}

void LinkAdapter::request(unsigned slot, Time now) {
  requests_ |= Word{1} << slot;
  client_.boot_requested(now);
}

bool LinkAdapter::answers(Offset offset, bool write) const {
  if (offset == symbols_.link_request) return true;
  const Offset within = offset - base;
  if (within >= slots_ * symbols_.link_words) return false;
  const Offset reg = within % symbols_.link_words;
  if (reg - symbols_.link_data < fifo_words) return write || reg == symbols_.link_data;
  return reg == symbols_.link_status && !write;
}

pci::Answer LinkAdapter::answer(pci::Address offset, unsigned, bool write, const pci::Access& access) {
  if (!is_host(access.agent) || !answers(base + offset, write)) return pci::Answer::abort;
  return most(offset, 1, write, access) == 0 ? pci::Answer::retry : pci::Answer::accept;
}

// Called before FRAME#, when other masters may still act before the access: answers for the FIFO's present state.
unsigned LinkAdapter::most(pci::Address offset, unsigned words, bool write, const pci::Access&) {
  if (!write || base + offset == symbols_.link_request) return 1;
  const Port& port = ports_[offset / symbols_.link_words];
  const auto room = static_cast<unsigned>(fifo_words - port.port.output.size());
  const auto registers = static_cast<unsigned>(symbols_.link_data + fifo_words - offset % symbols_.link_words);
  return std::min({words, room, registers});
}

void LinkAdapter::changed(Port& port, const pci::Access& access) {
  port.link->listener(near).changed(port.port, port_clock_.tick_at_or_after(clock_.at(access.clock)));
  client_.link_changed(port.slot);
}

Word LinkAdapter::read(pci::Address offset, const pci::Access& access) {
  if (base + offset == symbols_.link_request) return requests_;
  Port& port = ports_[offset / symbols_.link_words];
  port.link->advance_to(clock_.at(access.clock));
  if (offset % symbols_.link_words == symbols_.link_status) return port.port.control();
  if (port.port.input.empty()) return 0;
  const Word word = port.port.read();
  changed(port, access);
  return word;
}

void LinkAdapter::write(pci::Address offset, Word value, const pci::Access& access) {
  if (base + offset == symbols_.link_request) {
    for (Port& port : ports_)
      if ((requests_ & value) >> port.slot & 1) port.closed = false;
    requests_ &= ~value;
    return;
  }
  Port& port = ports_[offset / symbols_.link_words];
  if (port.closed && port.plugged) return;  // an empty slot is a cut link: the words stay in the FIFO
  port.link->advance_to(clock_.at(access.clock));
  port.port.write(value);
  changed(port, access);
}

std::vector<std::string> LinkAdapter::audit() const {
  std::vector<std::string> faults;
  for (const Port& port : ports_)
    if (auto fault = port.link->unbalanced()) faults.push_back(std::move(*fault));
  return faults;
}

void LinkAdapter::list_state(state::Visitor& list) {
  list("ports", ports_);
  list("requests", requests_);
}

void LinkAdapter::append_state(std::vector<std::uint64_t>& words) const {
  words.push_back(requests_);
  for (const Port& port : ports_) {
    words.push_back(port.port.control() | Word{port.closed} << 31);
    for (const c40::Fifo* fifo : {&port.port.input, &port.port.output})
      words.insert(words.end(), fifo->words().begin(), fifo->words().end());
    for (const int side : {near, far})
      words.insert(words.end(),
                   {port.link->counters(side).sent, port.link->counters(side).arrived, port.link->counters(side).lost});
  }
}

}  // namespace machine
