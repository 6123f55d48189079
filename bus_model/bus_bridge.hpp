#pragma once
// A transparent bridge between two buses (plant-and-bus.md 3.1, 3.4): a device behind it answers at its own addresses.
//
// Writes are posted in order; words of one agent at rising addresses form one burst. Reads are delayed: the bridge
// refuses a read until it has fetched the words on the other bus. PCI 2.1's ordering: a read starts on the far bus when
// the writes posted before the read have landed. Its data come back when all writes have landed that were posted in the
// other direction before the answer. Posted writes pass reads that are refused, so that no two bridges can wait for
// each other.
//
// Both buses must count the same clock. Inaccuracies: the posted writes and the reads of one direction have a REQ#
// each. The agent that wants a transaction travels with it, as a sideband; so does an agent's reset. No I/O or
// configuration cycles, no LOCK#.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bus_model/bus.hpp"

namespace pci {

class BusBridge {
 public:
  /// Called for each posted word that has reached a target on the far bus or, with a result other than done, has been
  /// lost.
  class Client {
   public:
    virtual ~Client() = default;
    virtual void delivered(const Bus& far, unsigned agent, Address address, Word value, Clocks clock,
                           Result result) = 0;
  };

  /// Adds two masters to each bus. The client may be null. Throws std::invalid_argument for impossible parameters.
  BusBridge(Bus& first, Bus& second, const BusBridgeConfig& config, Client* client);
  ~BusBridge();
  BusBridge(const BusBridge&) = delete;
  BusBridge& operator=(const BusBridge&) = delete;

  /// Claims [base, base + words) on `near`, one of the bridge's two buses; the target is on the other bus or behind it.
  void claim(Bus& near, const std::string& name, Address base, std::uint64_t words);
  /// The agent has left its bus, and starts again: what has been or is being read for it is no answer to its later
  /// reads. Words that it has posted continue. Call it after the agent's withdrawal from its bus.
  void forget(unsigned agent);
  /// Number of posted words under way, in both directions.
  std::size_t posted() const;
  void append_state(std::vector<std::uint64_t>& words) const;
  void list_state(state::Visitor& list);

 private:
  class Direction;
  std::unique_ptr<Direction> there_;
  std::unique_ptr<Direction> back_;
};

}  // namespace pci
