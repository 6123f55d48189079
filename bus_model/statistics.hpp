#pragma once
// What a bus counts about itself.
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "bus_model/config.hpp"
#include "state/visitor.hpp"

namespace pci {

/// Counts of clocks: exact below 2048, 1024 bins per octave above.
class Histogram {
 public:
  static constexpr std::size_t exact = 2048;

  void add(Clocks value) {
    if (static_cast<std::uint64_t>(value) < exact)
      counts_[static_cast<std::size_t>(value)] += 1;
    else
      add_other(value);
  }
  std::uint64_t count() const;
  Clocks sum() const;
  Clocks max() const;
  std::uint64_t zeros() const { return counts_[0]; }
  Clocks min() const;
  /// The smallest value that is not below `fraction` (0..1) of the entries. Exact up to `exact`; above, the upper edge
  /// of the value's bin, less than 0.1 % too high and never more than max().
  Clocks percentile(double fraction) const;
  /// Entries in [2^k, 2^(k+1)); element 0 holds 0 and 1.
  std::array<std::uint64_t, 32> octaves() const;
  void list_state(state::Visitor& list);

 private:
  static constexpr std::size_t bits = 10;  // bits below the highest one that select a value's bin
  static constexpr std::size_t bins = exact + (32 - bits - 1) * (std::size_t{1} << bits);
  void add_other(Clocks value);
  static std::size_t bin(Clocks value);
  static Clocks upper_edge(std::size_t bin);

  std::vector<std::uint64_t> counts_ = std::vector<std::uint64_t>(exact);  // only as long as the largest entry needs
  // Of the entries that are no index of an exact bin.
  Clocks others_sum_ = 0;
  Clocks others_max_ = 0;
  Clocks others_min_ = std::numeric_limits<Clocks>::max();
};

/// Each clock since clock 0 is counted in exactly one of these.
struct BusStatistics {
  Clocks address = 0;         ///< address phases
  Clocks data = 0;            ///< data phases
  Clocks wait = 0;            ///< DEVSEL#, wait states, refused attempts
  Clocks turnaround = 0;      ///< the idle clock at the end of a transaction
  Clocks idle_requested = 0;  ///< no master on the bus, at least one requests it
  Clocks idle = 0;
  Clocks total() const { return address + data + wait + turnaround + idle_requested + idle; }
};

struct MasterStatistics {
  std::uint64_t transactions = 0;
  std::uint64_t words_read = 0;
  std::uint64_t words_written = 0;
  std::uint64_t retries = 0;
  std::uint64_t disconnects = 0;  ///< stops by the target with words left
  std::uint64_t timer_stops = 0;  ///< stops by the latency timer with words left
  std::uint64_t aborts = 0;
  Clocks owned = 0;        ///< clocks on the bus
  Clocks arbitration = 0;  ///< REQ# to GNT#, of all transactions' first attempts in sum
  Clocks acquisition = 0;  ///< GNT# to FRAME#, the same
  Clocks target = 0;       ///< FRAME# to the first data phase, the same
  Histogram wait;          ///< clocks from the request to the first FRAME#
};

struct TargetStatistics {
  std::uint64_t words_read = 0;
  std::uint64_t words_written = 0;
  std::uint64_t retries = 0;
};

}  // namespace pci
