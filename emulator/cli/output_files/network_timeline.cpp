#include "cli/output_files/network_timeline.hpp"

#include <fmt/format.h>

#include <map>
#include <optional>
#include <vector>

#include "machine/networks/network.hpp"
#include "report/events/perfetto_trace.hpp"

namespace cli {
namespace {

using machine::Network;
using machine::NetworkEvent;
using machine::Time;
using report::PerfettoTrace;

/// A counter that writes one value per nanosecond: the last one.
class Level {
 public:
  Level(PerfettoTrace& trace, PerfettoTrace::Track track, std::int64_t first = 0)
      : trace_(trace), track_(track), value_(first) {}
  void add(Time at, std::int64_t change) { set(at, value_ + change); }
  void set(Time at, std::int64_t value) {
    if (at / std::chrono::nanoseconds{1} != changed_ / std::chrono::nanoseconds{1}) tell();
    changed_ = at;
    value_ = value;
  }
  void tell() {
    if (written_ != value_) trace_.count(track_, changed_, value_);
    written_ = value_;
  }

 private:
  PerfettoTrace& trace_;
  PerfettoTrace::Track track_;
  Time changed_{};
  std::int64_t value_;
  std::optional<std::int64_t> written_;
};

class Drawing {
 public:
  Drawing(const Network& network, std::ostream& out) : network_(network), trace_(out) {
    links_ = trace_.add_group("links", 0, "Words that arrive, and the number of words under way");
    for (std::size_t n = 0; n < network.link_count(); ++n) {
      const machine::NetworkLink& ends = network.ends(n);
      for (int side = 0; side < 2; ++side) {
        const auto& [from, to] = side == 0 ? std::pair(ends.a, ends.b) : std::pair(ends.b, ends.a);
        const std::string direction = fmt::format("{} > {}", to_text(from), to_text(to));
        const PerfettoTrace::Track words = trace_.add_slices(direction, links_);
        directions_.push_back(
            {words, from, to, Level(trace_, trace_.add_counter("on the way " + direction, "words", links_))});
        from_port_.emplace(from, directions_.size() - 1);
      }
    }
    for (std::size_t n = 0; n < network.chip_count(); ++n)
      chips_.push_back({trace_.add_group(fmt::format("chip {}", network.chip_name(n)))});
    for (std::size_t n = 0; n < network.net_count(); ++n) {
      const machine::Net& net = network.net(n);
      const bool first = net.level() != (net.edges() % 2 != 0);  // before its edges
      nets_.emplace_back(trace_, trace_.add_counter(fmt::format("net {}", net.description().name), "level"),
                         first ? 1 : 0);
    }
    events_ = trace_.add_slices("events", 0, "Losses, cuts, resets");
  }

  void draw() {
    const std::vector<NetworkEvent> events = network_.events();
    const std::vector<machine::ChipEvent> chips = network_.peripheral_events();
    auto chip = chips.begin();
    for (const NetworkEvent& event : events) {
      for (; chip != chips.end() && chip->time <= event.time; ++chip) happened(*chip);
      happened(event);
    }
    for (; chip != chips.end(); ++chip) happened(*chip);
    finish();
  }

 private:
  struct LinkDirection {
    PerfettoTrace::Track words;
    machine::PortName from, to;
    Level on_the_way;
  };
  struct Chip {
    PerfettoTrace::Track group;
    std::optional<PerfettoTrace::Track> events{};
    std::map<int, Level> fifos{};  // input FIFOs by port
    std::map<int, PerfettoTrace::Track> dmas{};
  };

  void happened(const NetworkEvent& event) {
    switch (event.kind) {
      case NetworkEvent::Kind::word: return arrived(event);
      case NetworkEvent::Kind::token: return;
      case NetworkEvent::Kind::rise: return nets_.at(event.place).set(event.time, 1);
      case NetworkEvent::Kind::fall: return nets_.at(event.place).set(event.time, 0);
      case NetworkEvent::Kind::lost: direction(event).on_the_way.add(event.time, -1); break;
      case NetworkEvent::Kind::discarded: discarded(event); break;
      default: break;
    }
    const std::string text = network_.text(event);
    const PerfettoTrace::Note notes[] = {{"event", text}};
    trace_.instant(events_, event.time, name(event.kind), notes);
  }

  LinkDirection& direction(const NetworkEvent& event) {
    return directions_.at(2 * event.place + static_cast<std::size_t>(event.side));
  }

  void arrived(const NetworkEvent& event) {
    LinkDirection& its = direction(event);
    const std::string word = fmt::format("{:08X}h", event.word);
    const PerfettoTrace::Note notes[] = {{"word", word}};
    trace_.instant(its.words, event.time, "word", notes);
    its.on_the_way.add(event.time, -1);
    fifo(its.to.chip, its.to.port).add(event.time, 1);
  }

  void discarded(const NetworkEvent& event) {
    const auto out = from_port_.find({event.place, event.side});
    if (event.count != 0)
      fifo(event.place, event.side).add(event.time, -1);
    else if (out != from_port_.end())
      directions_.at(out->second).on_the_way.add(event.time, -1);
  }

  void happened(const machine::ChipEvent& chip_event) {
    using Kind = c40::PeripheralEvent::Kind;
    Chip& chip = chips_.at(chip_event.chip);
    const c40::PeripheralEvent& event = chip_event.event;
    switch (event.kind) {
      case Kind::port_write:
        if (const auto out = from_port_.find({chip_event.chip, event.number}); out != from_port_.end())
          directions_.at(out->second).on_the_way.add(chip_event.time, 1);
        return;
      case Kind::port_read: return fifo(chip_event.chip, event.number).add(chip_event.time, -1);
      case Kind::dma_start:
      case Kind::dma_end: return dma(chip, chip_event.time, event);
      case Kind::timer:
      case Kind::interrupt: break;
    }
    if (!chip.events) chip.events = trace_.add_slices("interrupts and timers", chip.group);
    const PerfettoTrace::Note notes[] = {{"number", static_cast<std::int64_t>(event.number)}};
    trace_.instant(*chip.events, chip_event.time, name(event.kind), notes);
  }

  void dma(Chip& chip, Time at, const c40::PeripheralEvent& event) {
    auto found = chip.dmas.find(event.number);
    if (found == chip.dmas.end())
      found = chip.dmas.emplace(event.number, trace_.add_slices(fmt::format("DMA {}", event.number), chip.group)).first;
    if (trace_.depth(found->second) > 0) trace_.end(found->second, at);
    if (event.kind == c40::PeripheralEvent::Kind::dma_start) trace_.begin(found->second, at, "block");
  }

  Level& fifo(std::size_t chip, int port) {
    auto& fifos = chips_.at(chip).fifos;
    const auto found = fifos.find(port);
    if (found != fifos.end()) return found->second;
    const PerfettoTrace::Track track =
        trace_.add_counter(fmt::format("input FIFO {}", port), "words", chips_.at(chip).group);
    return fifos.try_emplace(port, trace_, track).first->second;
  }

  void finish() {
    for (LinkDirection& its : directions_) its.on_the_way.tell();
    for (Level& net : nets_) net.tell();
    for (Chip& chip : chips_) {
      for (auto& [port, level] : chip.fifos) level.tell();
      for (const auto& [number, track] : chip.dmas) {
        if (trace_.depth(track) > 0) trace_.end(track, network_.now());
      }
    }
  }

  const Network& network_;
  PerfettoTrace trace_;
  PerfettoTrace::Track links_ = 0, events_ = 0;
  std::vector<LinkDirection> directions_;  // two for each link
  std::map<machine::PortName, std::size_t> from_port_;
  std::vector<Chip> chips_;
  std::vector<Level> nets_;
};

}  // namespace

void draw_network(const Network& network, std::ostream& out) { Drawing(network, out).draw(); }

}  // namespace cli
