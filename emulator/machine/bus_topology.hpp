#pragma once
// Which agent stands on which bus, and what follows from it: where each device answers, and by which way a board
// reaches it (plant-and-bus.md 3.4).
//
// A DSP's program knows two windows only: shared memory in window A, devices in window B. The board's decoder sends an
// access out by that of its bridges which leads to the device, at the device's address on the buses. Buses that bridges
// join share one address space; the others have one each.
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "bus_model/config.hpp"

namespace machine {

using Offset = std::uint32_t;

/// The devices of window B, by what they belong to.
enum class DeviceGroup : std::uint8_t { drives, sensors, comm_port };
inline constexpr std::size_t device_groups = 3;

struct Topology {
  std::vector<std::string> buses{"A", "B"};
  std::vector<unsigned> host{0};     ///< the buses on which it has a bridge
  std::vector<unsigned> dsps{0, 1};  ///< the same of every DSP board
  unsigned shared_memory = 0;
  std::array<unsigned, device_groups> devices{1, 1, 1};         ///< by DeviceGroup
  std::array<pci::Address, device_groups> devices_at{0, 0, 0};  ///< address of window B's offset 0 on the bus
  std::vector<std::pair<unsigned, unsigned>> bridges;           ///< between buses; no loops
};

/// Words of window B, and of the part of the address space that shared memory, its registers and the link adapter take.
inline constexpr Offset device_space = 0x1000;
inline constexpr Offset shared_space = 0x12000;
/// Where devices begin in an address space that they share with shared memory, unless told otherwise.
inline constexpr Offset devices_beside_memory = 0x100000;

/// The next bus on the way from one bus to another over bridges; `from` itself when they are the same, -1 when no way
/// leads there.
int next_bus(const Topology& topology, unsigned from, unsigned to);
/// Bridges to cross; -1 when no way leads there.
int hops(const Topology& topology, unsigned from, unsigned to);

/// A part of a window as a board reaches it.
struct BusRoute {
  Offset first = 0;
  Offset end = 0;          ///< one past the last offset of the part
  unsigned bus = 0;        ///< where the target stands
  unsigned port = 0;       ///< index of the board's bridge, in the order in which its buses were given
  pci::Address shift = 0;  ///< address on the bus = offset + shift
  bool direct = true;      ///< the target stands on that very bus
};

/// The shortest way for a board that stands on `standing`; ties go to the bus named first. std::invalid_argument when
/// none leads there.
BusRoute route_to(const Topology& topology, const std::vector<unsigned>& standing, unsigned bus, Offset first,
                  Offset end, pci::Address shift);

/// Throws std::invalid_argument for a bus that is not there, a loop of bridges or an agent without a bus.
void check(const Topology& topology);

}  // namespace machine
