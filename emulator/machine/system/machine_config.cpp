#include "machine/system/machine_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "machine/dsps/slot_links.hpp"
#include "machine/networks/net_description.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/system/scripted_events.hpp"

namespace machine {
namespace {

Skew skew_of(const std::vector<Skew>& skews, std::size_t number) {
  return number < skews.size() ? skews[number] : Skew{};
}

}  // namespace

void require_sense(const ScriptedEvent& event, Time now, const Config& config) {
  require_sense(event, now, config.slots, static_cast<unsigned>(config.topology.buses.size()));
}

Config checked(Config config) {
  if (config.slots == 0) config.slots = config.dsps;
  if (config.slots > most_slots || config.dsps > config.slots)
    throw std::invalid_argument{
        fmt::format("machine: {} DSPs in {} slots; there are at most {} slots and no more DSPs than slots", config.dsps,
                    config.slots, most_slots)};
  check(config.topology);
  check(config.links, config.slots);
  check_slot_nets(config.nets, config.slots);
  if (config.interrupt_clocks < 1 || config.interrupt_clocks > 3)
    throw std::invalid_argument{"machine: interrupt_clocks is 1 to 3"};
  if (config.prefetch_hit_cycles < 0) throw std::invalid_argument{"machine: prefetch_hit_cycles is at least 0"};
  for (const ScriptedEvent& event : config.script) require_sense(event, Time{0}, config);
  std::stable_sort(config.script.begin(), config.script.end(),
                   [](const ScriptedEvent& a, const ScriptedEvent& b) { return a.time < b.time; });
  return config;
}

Skew skew_of_chip(const Config& config, unsigned slot) { return skew_of(config.chip_skews, slot); }

// A bridge between buses gives its far side the clock of its near side.
Skew skew_of_bus(const Config& config, unsigned bus) {
  unsigned first = 0;
  while (hops(config.topology, first, bus) < 0) ++first;
  return skew_of(config.bus_skews, first);
}

std::vector<Clock> clocks_of_chips(const Config& config) {
  std::vector<Clock> all;
  for (unsigned slot = 0; slot < config.slots; ++slot)
    all.push_back(skew_of_chip(config, slot).clock(config.chip_hz, config.chip_hz_denominator));
  return all;
}

std::vector<Clock> clocks_of_buses(const Config& config) {
  std::vector<Clock> all;
  for (unsigned bus = 0; bus < config.topology.buses.size(); ++bus)
    all.push_back(skew_of_bus(config, bus).clock(config.pci_hz_numerator, config.pci_hz_denominator));
  return all;
}

}  // namespace machine
