#include "cmrc/timelines/perfetto_buses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "report/events/event.hpp"

namespace cmrc {
namespace {

using report::Time;
constexpr Time bus_sample_period = std::chrono::milliseconds{1};

std::string_view name(pci::Attempt::Kind kind) {
  switch (kind) {
    case pci::Attempt::Kind::data: return "data";
    case pci::Attempt::Kind::retry: return "retry";
    case pci::Attempt::Kind::master_abort: return "master abort";
    case pci::Attempt::Kind::target_abort: return "target abort";
  }
  return "unknown";
}

}  // namespace

PerfettoBuses::PerfettoBuses(Trace& trace, const machine::Machine& machine, bool each, report::Window window)
    : trace_(trace), window_(window) {
  for (unsigned i = 0; i < machine.buses(); ++i) {
    const pci::Bus& its = machine.bus(static_cast<machine::BusId>(i));
    const std::string title = report::name(static_cast<report::Component>(report::bus_a + i));
    const Trace::Track group =
        trace_.add_group(title, 0, "Clocks of each millisecond in which a master was on the bus, turnarounds left out");
    Bus bus;
    if (each)
      bus.slices = trace_.add_slices("transactions", group, "From FRAME# to the last data phase or stop, by master");
    for (unsigned m = 0; m < its.masters(); ++m)
      bus.masters.push_back({trace_.add_counter(its.master_name(m), "clocks/ms", group), its.master_name(m)});
    for (unsigned t = 0; t < its.targets(); ++t) bus.targets.push_back(its.target_name(t));
    buses_.push_back(std::move(bus));
  }
}

// Brings the bus to this millisecond; writes the counts of the one before.
void PerfettoBuses::tell(Bus& bus, std::int64_t millisecond) {
  if (millisecond <= bus.millisecond) return;
  const auto count = [&](Master& master, Time at, std::int64_t clocks) {
    if (clocks == master.written || !window_.contains(at)) return;
    trace_.count(master.track, at, clocks);
    master.written = clocks;
  };
  for (Master& master : bus.masters) {
    count(master, bus_sample_period * bus.millisecond, master.clocks);
    master.clocks = 0;
    if (millisecond > bus.millisecond + 1) count(master, bus_sample_period * (bus.millisecond + 1), 0);
  }
  bus.millisecond = millisecond;
}

void PerfettoBuses::on_bus(machine::BusId id, const pci::Attempt& attempt, const machine::Clock& clock, bool ended) {
  Bus& bus = buses_.at(static_cast<std::size_t>(id));
  const pci::Clocks until = attempt.last + 1;
  for (pci::Clocks at = attempt.frame; at < until;) {
    const std::int64_t millisecond = clock.at(at) / bus_sample_period;
    tell(bus, millisecond);
    const pci::Clocks next = std::min(until, clock.tick_at_or_after(bus_sample_period * (millisecond + 1)));
    bus.masters.at(attempt.master).clocks += next - at;
    at = next;
  }
  if (bus.slices) slice(bus, attempt, clock.at(attempt.frame), clock.at(until), ended);
}

void PerfettoBuses::slice(const Bus& bus, const pci::Attempt& attempt, Time from, Time to, bool ended) {
  if (from >= window_.to || to <= window_.from) return;
  const std::string address = fmt::format("{:X}h", attempt.address);
  const Trace::Note notes[] = {
      {"address", address},
      {"words", static_cast<std::int64_t>(attempt.words)},
      {"access", attempt.write ? "write" : "read"},
      {"target",
       attempt.target < 0 ? std::string_view("nobody") : bus.targets.at(static_cast<std::size_t>(attempt.target))},
      {"waited_clocks", attempt.frame - attempt.requested},
      {"end", ended ? name(attempt.kind) : std::string_view("running")}};
  trace_.begin(*bus.slices, from, bus.masters.at(attempt.master).name,
               std::span(notes).first(ended && attempt.kind == pci::Attempt::Kind::data ? 5 : 6));
  trace_.end(*bus.slices, to);
}

void PerfettoBuses::finish() {
  for (Bus& bus : buses_) tell(bus, bus.millisecond + 2);
}

}  // namespace cmrc
