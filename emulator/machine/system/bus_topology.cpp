#include "machine/system/bus_topology.hpp"

#include <fmt/format.h>

#include <numeric>
#include <stdexcept>

namespace machine {

namespace {

// Bridges form a forest: a depth-first walk that never turns back finds the only path.
bool leads_to(const Topology& topology, unsigned from, unsigned to, int came_from, std::vector<unsigned>& path) {
  if (from == to) return true;
  for (const auto& [a, b] : topology.bridges) {
    if (a != from && b != from) continue;
    const unsigned next = a == from ? b : a;
    if (static_cast<int>(next) == came_from) continue;
    path.push_back(next);
    if (leads_to(topology, next, to, static_cast<int>(from), path)) return true;
    path.pop_back();
  }
  return false;
}

}  // namespace

int next_bus(const Topology& topology, unsigned from, unsigned to) {
  std::vector<unsigned> path;
  if (!leads_to(topology, from, to, -1, path)) return -1;
  return static_cast<int>(path.empty() ? from : path.front());
}

int hops(const Topology& topology, unsigned from, unsigned to) {
  std::vector<unsigned> path;
  return leads_to(topology, from, to, -1, path) ? static_cast<int>(path.size()) : -1;
}

BusRoute route_to(const Topology& topology, const std::vector<unsigned>& standing, unsigned bus, Offset first,
                  Offset end, pci::Address shift) {
  int best = -1;
  BusRoute route{.first = first, .end = end, .bus = bus, .shift = shift};
  for (std::size_t port = 0; port < standing.size(); ++port) {
    const int far = hops(topology, standing[port], bus);
    if (far < 0 || (best >= 0 && far >= best)) continue;
    best = far;
    route.port = static_cast<unsigned>(port);
    route.direct = far == 0;
  }
  if (best < 0) throw std::invalid_argument{fmt::format("machine: no bridge leads to bus {}", topology.buses.at(bus))};
  return route;
}

void check(const Topology& topology) {
  const auto count = topology.buses.size();
  const auto require = [](bool good, const char* what) {
    if (!good) throw std::invalid_argument{std::string{"machine: "} + what};
  };
  require(count >= 1 && count <= 4, "there are 1 to 4 buses");
  require(!topology.host.empty() && !topology.dsps.empty(), "host and DSPs are on at least one bus each");
  const auto there = [&](unsigned bus) { require(bus < count, "an agent is on a bus that does not exist"); };
  for (const unsigned bus : topology.host) there(bus);
  for (const unsigned bus : topology.dsps) there(bus);
  for (const unsigned bus : topology.devices) there(bus);
  there(topology.shared_memory);
  std::vector<unsigned> island(count);
  std::iota(island.begin(), island.end(), 0u);
  for (const auto& [a, b] : topology.bridges) {
    there(a);
    there(b);
    require(island[a] != island[b], "bridges form a loop");
    const unsigned gone = island[b];
    for (unsigned& one : island)
      if (one == gone) one = island[a];
  }
}

}  // namespace machine
