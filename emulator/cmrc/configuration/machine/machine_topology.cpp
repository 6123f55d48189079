#include "cmrc/configuration/machine/machine_topology.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <stdexcept>

#include "cmrc/configuration/config.hpp"
#include "isa/ascii.hpp"

namespace cmrc {
namespace {

using machine::Topology;

struct TopologyRow {
  std::string_view buses, host, boards, shared_memory, drives, sensors, comm_port;
};

// In the order of TopologyPreset.
constexpr TopologyRow presets_of_topology[] = {
    {"A B", "A", "A B", "A", "B", "B", "B"},
    {"A B", "A B", "A B", "A", "B", "B", "B"},
    {"A B", "A", "A B", "A", "B", "A", "A"},
    {"A", "A", "A", "A", "A", "A", "A"},
};

std::vector<std::string_view> words_of(std::string_view text) { return ascii::words(text, " ,+"); }

class Reader {
 public:
  Reader(const Config& config, const Contradiction& contradiction) : config_{config}, contradiction_{contradiction} {}

  Topology read() {
    const Config::Topology& own = config_.topology;
    const TopologyRow& preset = presets_of_topology[static_cast<std::size_t>(config_.bus.topology)];
    const auto chosen = [](const std::string& given, std::string_view otherwise) {
      return given.empty() ? std::string{otherwise} : given;
    };
    read_buses(chosen(own.buses, preset.buses));
    topology_.host = places("topology.host", chosen(own.host, preset.host));
    topology_.dsps = places("topology.boards", chosen(own.boards, preset.boards));
    topology_.shared_memory = place("topology.shared_memory", chosen(own.shared_memory, preset.shared_memory));
    topology_.devices = {place(device_keys[0], chosen(own.drives, preset.drives)),
                         place(device_keys[1], chosen(own.sensors, preset.sensors)),
                         place(device_keys[2], chosen(own.comm_port, preset.comm_port))};
    read_bridges(own.bridges);
    reach();
    addresses();
    return topology_;
  }

 private:
  static constexpr std::string_view device_keys[] = {"topology.drives", "topology.sensors", "topology.comm_port"};
  static constexpr std::string_view address_keys[] = {"topology.drives_at", "topology.sensors_at",
                                                      "topology.comm_port_at"};

  void require(bool good, const std::vector<std::string_view>& keys, const std::string& what,
               const std::string& right) const {
    if (!good) contradiction_(keys, what, right);
  }

  std::string bus_list() const { return fmt::format("{}", fmt::join(topology_.buses, ", ")); }

  void read_buses(const std::string& text) {
    const auto buses = words_of(text);
    topology_.buses = {buses.begin(), buses.end()};
    const std::size_t count = topology_.buses.size();
    bool good = count >= 1 && count <= 4;
    for (std::size_t i = 0; i < count && good; ++i)
      good = topology_.buses[i] == std::string(1, static_cast<char>('A' + i));
    require(good, {"topology.buses", "bus.topology"}, fmt::format("\"{}\" is not a list of buses", text),
            "\"A\", \"A B\", \"A B C\" or \"A B C D\" is expected");
  }

  unsigned number(std::string_view key, std::string_view name) const {
    const auto found = std::ranges::find(topology_.buses, name);
    require(found != topology_.buses.end(), {key, "topology.buses", "bus.topology"},
            fmt::format("there is no bus {}", name), fmt::format("the buses are {} (topology.buses)", bus_list()));
    return static_cast<unsigned>(found - topology_.buses.begin());
  }

  std::vector<unsigned> places(std::string_view key, const std::string& text) const {
    std::vector<unsigned> all;
    for (const std::string_view name : words_of(text)) {
      const unsigned bus = number(key, name);
      require(std::ranges::find(all, bus) == all.end(), {key}, fmt::format("bus {} is named twice", name),
              "each bus once is expected");
      all.push_back(bus);
    }
    require(!all.empty(), {key}, "no bus is named", "one or several buses are expected, as in \"A B\"");
    return all;
  }

  unsigned place(std::string_view key, const std::string& text) const {
    const auto all = places(key, text);
    require(all.size() == 1, {key}, fmt::format("it is on {} buses", all.size()), "a target is on one bus");
    return all.front();
  }

  void read_bridges(const std::string& text) {
    static constexpr std::string_view key = "topology.bridges";
    std::vector<unsigned> island(topology_.buses.size());
    std::iota(island.begin(), island.end(), 0u);
    for (const std::string_view word : words_of(text)) {
      const std::size_t dash = word.find('-');
      require(dash != std::string::npos, {key}, fmt::format("\"{}\" is not a bridge", word),
              "two buses are expected, as in \"A-B\"");
      const unsigned a = number(key, word.substr(0, dash)), b = number(key, word.substr(dash + 1));
      require(a != b, {key}, fmt::format("{} connects a bus to itself", word), "two buses are expected, as in \"A-B\"");
      require(island[a] != island[b], {key}, fmt::format("with {} the bridges form a loop", word),
              "only one route is possible between two buses");
      for (const unsigned gone = island[b]; unsigned& one : island)
        if (one == gone) one = island[a];
      topology_.bridges.emplace_back(a, b);
    }
  }

  bool leads(const std::vector<unsigned>& standing, unsigned bus) const {
    return std::ranges::any_of(standing, [&](unsigned from) { return machine::hops(topology_, from, bus) >= 0; });
  }

  void reach() const {
    const auto must = [&](std::string_view who_key, const char* who, const std::vector<unsigned>& standing,
                          std::string_view key, const char* what, unsigned bus) {
      require(leads(standing, bus), {key, who_key, "topology.bridges", "bus.topology"},
              fmt::format("{} cannot reach {} on bus {}", who, what, topology_.buses[bus]),
              fmt::format("put both on one bus, or connect their buses by topology.bridges"));
    };
    must("topology.boards", "the DSPs", topology_.dsps, "topology.shared_memory", "shared memory",
         topology_.shared_memory);
    must("topology.host", "the host", topology_.host, "topology.shared_memory", "shared memory",
         topology_.shared_memory);
    static constexpr const char* names[] = {"the drives", "the sensors", "the comm port"};
    for (std::size_t i = 0; i < machine::device_groups; ++i)
      must("topology.boards", "the DSPs", topology_.dsps, device_keys[i], names[i], topology_.devices[i]);
  }

  // Devices keep their places in window B's 1000h words. If they share an address space with shared memory, or if the
  // user says so, these words do not begin at 0.
  void addresses() {
    const std::int64_t given[] = {config_.topology.drives_at, config_.topology.sensors_at,
                                  config_.topology.comm_port_at};
    const auto meets = [&](unsigned a, unsigned b) { return machine::hops(topology_, a, b) >= 0; };
    for (std::size_t i = 0; i < machine::device_groups; ++i) {
      const bool beside_memory = meets(topology_.devices[i], topology_.shared_memory);
      const std::int64_t at = given[i] >= 0 ? given[i] : beside_memory ? machine::devices_beside_memory : 0;
      require(
          !beside_memory || at >= machine::shared_space, {address_keys[i]},
          fmt::format("{:X}h overlaps shared memory and its registers at 0 to {:X}h", at, machine::shared_space - 1),
          fmt::format("at least {:#x} is expected, or -1 to have it chosen", machine::shared_space));
      topology_.devices_at[i] = static_cast<pci::Address>(at);
      for (std::size_t k = 0; k < i; ++k) {
        const std::int64_t other = topology_.devices_at[k];
        const bool apart = !meets(topology_.devices[i], topology_.devices[k]) || at == other ||
                           std::abs(at - other) >= std::int64_t{machine::device_space};
        require(
            apart, {address_keys[i], address_keys[k]},
            fmt::format("the windows at {:X}h ({}) and {:X}h ({}) overlap", at, device_keys[i], other, device_keys[k]),
            fmt::format("the same address, or {:#x} words between them, is expected", machine::device_space));
      }
    }
  }

  const Config& config_;
  const Contradiction& contradiction_;
  Topology topology_;
};

}  // namespace

Topology topology_of(const Config& config, const Contradiction& contradiction) {
  return Reader{config, contradiction}.read();
}

Topology topology_of(const Config& config) {
  return topology_of(config,
                     [](const auto&, const std::string& what, const std::string&) { throw std::logic_error{what}; });
}

}  // namespace cmrc
