#include "machine/dsps/slot_links.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <stdexcept>

#include "isa/ascii.hpp"
#include "machine/dsps/dsp.hpp"

namespace machine {

namespace {

c40::Link::Side side_of(const SlotPort& end, Dsp& dsp) {
  return {fmt::format("DSP {} port {}", end.slot, end.port), end.port, &dsp.chip().port(end.port), dsp.clock()};
}

}  // namespace

std::string to_text(const SlotPort& port) { return fmt::format("{}.{}", port.slot, port.port); }
std::string to_text(const SlotLink& link) { return to_text(link.a) + ":" + to_text(link.b); }

std::vector<SlotLink> parse_slot_links(std::string_view text) {
  std::vector<SlotLink> links;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    const std::string_view one = ascii::trimmed(text.substr(from, comma - from), " ");
    std::string_view rest = one;
    const auto unclear = [&] {
      return std::invalid_argument{
          fmt::format("\"{}\" is not a link; SLOT.PORT:SLOT.PORT is expected, as 0.1:1.4", one)};
    };
    const auto number = [&](char behind) {
      unsigned value = 0;
      const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
      const auto length = static_cast<std::size_t>(end - rest.data());
      const bool ends = behind == 0 ? length == rest.size() : length < rest.size() && *end == behind;
      if (error != std::errc{} || !ends) throw unclear();
      rest.remove_prefix(length + (behind == 0 ? 0 : 1));
      return value;
    };
    SlotLink link;
    link.a.slot = number('.'), link.a.port = static_cast<int>(number(':'));
    link.b.slot = number('.'), link.b.port = static_cast<int>(number(0));
    if (link.a.port > link.b.port) std::swap(link.a, link.b);
    links.push_back(link);
    from = comma + 1;
  }
  return links;
}

void check(const std::vector<SlotLink>& links, unsigned slots) {
  std::vector<SlotPort> taken;
  for (const SlotLink& link : links) {
    const std::string name = to_text(link);
    for (const SlotPort& end : {link.a, link.b}) {
      if (end.slot >= slots)
        throw std::invalid_argument{
            fmt::format("link {}: there is no slot {}; the last is {}", name, end.slot, slots - 1)};
      if (end.port < 0 || end.port >= c40::port_count)
        throw std::invalid_argument{
            fmt::format("link {}: a DSP has no port {}; ports 0, 1, 2, 4 and 5 are free", name, end.port)};
      if (end.port == 3)
        throw std::invalid_argument{fmt::format(
            "link {}: port 3 of every DSP is linked to the link adapter; ports 0, 1, 2, 4 and 5 are free", name)};
      if (std::ranges::find(taken, end) != taken.end())
        throw std::invalid_argument{
            fmt::format("link {}: port {} already has a link; a port has one link", name, to_text(end))};
      taken.push_back(end);
    }
    if (link.a.slot == link.b.slot)
      throw std::invalid_argument{
          fmt::format("link {}: both ends are in slot {}; a link connects two slots", name, link.a.slot)};
    if (link.a.port > 2 || link.b.port < 4)
      throw std::invalid_argument{fmt::format(
          "link {}: one of ports 0, 1, 2, which begin with the token, must be connected to one of ports 4, 5", name)};
  }
}

SlotWire::SlotWire(SlotLink ends, Dsp& a, Dsp& b)
    : ends_{ends}, a_{a}, b_{b}, link_{side_of(ends.a, a), side_of(ends.b, b)} {
  link_.cut(Time{0});
  a.attach(ends.a.port, link_, 0, *this);
  b.attach(ends.b.port, link_, 1, *this);
  slots_changed(Time{0});
}

Time SlotWire::next() const { return std::min(joins_, link_.next_event()); }

void SlotWire::act(Time now) {
  link_.advance_to(now);
  if (joins_ <= now) {
    joins_ = never;
    joined_ += 1;
    reset_ports(now);
    link_.restore(now);
  }
  a_.link_moved(now);
  b_.link_moved(now);
}

// A DSP may be ahead by a time in which nothing on a link can reach it; the wires are connected after this time.
void SlotWire::slots_changed(Time now) {
  const bool join = a_.booted() && b_.booted();
  if (join && link_.is_cut()) {
    joins_ = now + link_.lookahead();
  } else if (!join) {
    joins_ = never;
    if (!link_.is_cut()) link_.cut(now);
  }
  changed();
}

void SlotWire::reset_ports(Time now) {
  for (const int side : {0, 1}) {
    Dsp& dsp = side == 0 ? a_ : b_;
    const int number = side == 0 ? ends_.a.port : ends_.b.port;
    c40::CommPort& port = dsp.chip().port(number);
    const c40::Cycles at = dsp.clock().tick_at_or_before(now);
    link_.listener(side).about_to_reset(at);
    port.reset(number);
    link_.listener(side).was_reset(port, at);
  }
}

SlotLinkTraffic SlotWire::traffic(int side) const {
  const c40::PortTraffic& from = (side == 0 ? a_ : b_).chip().port(side == 0 ? ends_.a.port : ends_.b.port).traffic;
  const c40::PortTraffic& to = (side == 0 ? b_ : a_).chip().port(side == 0 ? ends_.b.port : ends_.a.port).traffic;
  const c40::Link::Counters& counters = link_.counters(side);
  return {counters.sent, counters.arrived, counters.lost, from.discarded_output + to.discarded_input};
}

void SlotWire::list_state(state::Visitor& list) {
  list("link", link_);
  list("joins", joins_);
  list("joined", joined_);
}

void SlotWire::append_state(std::vector<std::uint64_t>& words) const {
  words.push_back(joined_);
  words.push_back(link_.is_cut());
  for (const int side : {0, 1}) {
    const SlotLinkTraffic of = traffic(side);
    words.insert(words.end(), {of.sent, of.arrived, of.lost, of.discarded});
  }
}

}  // namespace machine
