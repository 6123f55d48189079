#pragma once
// A transparent bridge between two buses (plant-and-bus.md 3.1, 3.4): what lies behind it answers at its own addresses.
//
// Writes are posted, in order, words at rising addresses of one agent as one burst. Reads are delayed: refused until
// the words have been fetched on the other bus. PCI 2.1's ordering: a read starts on the far bus when the writes posted
// before it have landed; its data come back when the writes that were posted the other way before it was answered have
// landed; posted writes pass reads that are refused, so that no two bridges can wait for each other.
//
// Both buses must count the same clock. Inaccuracies: the posted writes and the reads of one direction ask by a REQ#
// each; the agent for whom a transaction is travels with it, as a sideband; no I/O or configuration cycles, no LOCK#.
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "bus_model/bus.hpp"

namespace pci {

class BusBridge {
 public:
  /// Told of each posted word that has reached a target on the far bus (or, result not done, has been lost).
  class Client {
   public:
    virtual ~Client() = default;
    virtual void delivered(const Bus& far, unsigned agent, Address address, Word value, Clocks clock,
                           Result result) = 0;
  };

  /// Becomes two masters of each bus. The client may be null. Throws std::invalid_argument for impossible parameters.
  BusBridge(Bus& first, Bus& second, const BusBridgeConfig& config, Client* client);
  ~BusBridge();
  BusBridge(const BusBridge&) = delete;
  BusBridge& operator=(const BusBridge&) = delete;

  /// Claims [base, base + words) on `near`, one of its buses; the target lies on the other one or behind it.
  void claim(Bus& near, const std::string& name, Address base, std::uint64_t words);
  /// Posted words under way, both directions.
  std::size_t posted() const;
  void append_state(std::vector<std::uint64_t>& words) const;
  void list_state(state::Visitor& list);

 private:
  class Direction;
  std::unique_ptr<Direction> there_;
  std::unique_ptr<Direction> back_;
};

}  // namespace pci
