#pragma once
// The bus of each agent, and what follows from it: the address at which each device answers, and the route by which a
// board reaches it (plant-and-bus.md 3.4).
//
// A DSP's program knows two windows only: shared memory in window A, devices in window B. The board's decoder sends an
// access to the bridge that leads to the device, with the device's address on the buses. Buses connected by bridges
// share one address space; other buses have one each.
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "bus_model/config.hpp"

namespace machine {

using Word = std::uint32_t;
/// A C40's address minus the window's base. The host's program uses the offsets of window A.
using Offset = std::uint32_t;

inline constexpr unsigned most_slots = 16;

enum class BusId : std::uint8_t { a, b, c, d };
/// The windows of a DSP; by default bus A and bus B are behind them.
enum class Window : std::uint8_t { a, b };
/// The host's program finds offset 0 of window B here, if its board has a route to it.
inline constexpr Offset host_devices = 0x100000;

/// The devices of window B, by their groups.
enum class DeviceGroup : std::uint8_t { drives, sensors, comm_port };
inline constexpr std::size_t device_groups = 3;

struct Topology {
  std::vector<std::string> buses{"A", "B"};
  std::vector<unsigned> host{0};     ///< the buses to which the host has a bridge
  std::vector<unsigned> dsps{0, 1};  ///< the buses of every DSP board
  unsigned shared_memory = 0;
  std::array<unsigned, device_groups> devices{1, 1, 1};         ///< by DeviceGroup
  std::array<pci::Address, device_groups> devices_at{0, 0, 0};  ///< address of window B's offset 0 on the bus
  std::vector<std::pair<unsigned, unsigned>> bridges;           ///< between buses; no loops
};

/// Words of window B, and of the part of the address space for shared memory, its registers and the link adapter.
inline constexpr Offset device_space = 0x1000;
inline constexpr Offset shared_space = 0x12000;
/// Default address of the devices in an address space that they share with shared memory.
inline constexpr Offset devices_beside_memory = 0x100000;

/// The next bus on the route from one bus to another; `from` itself if they are the same, -1 if there is no route.
int next_bus(const Topology& topology, unsigned from, unsigned to);
/// Number of bridges on the route; -1 if there is none.
int hops(const Topology& topology, unsigned from, unsigned to);

/// The route of a board to a part of a window.
struct BusRoute {
  Offset first = 0;
  Offset end = 0;          ///< one past the last offset of the part
  unsigned bus = 0;        ///< the bus of the target
  unsigned port = 0;       ///< index of the board's bridge, in the order of the board's buses
  pci::Address shift = 0;  ///< address on the bus = offset + shift
  bool direct = true;      ///< the target is on that bus itself

  bool holds(Offset offset) const { return offset - first < end - first; }
};

/// The shortest route for a board on the buses `standing`; of equal routes, the one by the bus named first.
/// std::invalid_argument if there is none.
BusRoute route_to(const Topology& topology, const std::vector<unsigned>& standing, unsigned bus, Offset first,
                  Offset end, pci::Address shift);

/// Throws std::invalid_argument for a bus that does not exist, a loop of bridges or an agent without a bus.
void check(const Topology& topology);

}  // namespace machine
