#pragma once
// Parameters of a PCI bus, its masters, its targets and the bridges in front of it. All times are whole bus clocks (30
// ns at 33 1/3 MHz). Defaults: plant-and-bus.md 3.6.
#include <cstdint>
#include <string>

namespace pci {

using Word = std::uint32_t;
using Address = std::uint32_t;  ///< of a 32-bit word, not of a byte
using Clocks = std::int64_t;

inline constexpr Clocks never = INT64_MAX;
/// A target drops the answer of a delayed read that no master has fetched for so long (PCI 2.1).
inline constexpr Clocks discard_clocks = Clocks{1} << 15;

enum class Arbitration : std::uint8_t {
  round_robin,  ///< the next master after the last owner
  fixed,        ///< the lowest number first
  two_level,    ///< round robin among the first-level masters; the round robin of all others counts as one of them
  host_fair,    ///< two_level with master 0 (the host bridge) alone on the first level: it gets every other turn
};

enum class Parking : std::uint8_t {
  none,        ///< no master keeps GNT# on an idle bus
  last_owner,  ///< the last owner keeps GNT# and may start at once
  first,       ///< master 0 (the host bridge) gets GNT#
};

/// PCI's memory commands; I/O and configuration cycles are not modelled.
enum class Command : std::uint8_t {
  read,           ///< Memory Read: one or two words, no words fetched ahead
  read_line,      ///< Memory Read Line: more words, of one cache line
  read_multiple,  ///< Memory Read Multiple: of more than one line
  write,
  write_invalidate,  ///< whole lines: the latency timer lets the write continue to the end of a line
};
constexpr bool is_write(Command command) { return command >= Command::write; }

struct BusConfig {
  std::string name = "bus";
  Arbitration arbitration = Arbitration::round_robin;
  Parking parking = Parking::last_owner;
  Clocks grant_clocks = 2;         ///< REQ# to FRAME# on an idle bus whose grant is parked elsewhere
  bool fast_back_to_back = false;  ///< no turnaround after a write if the same master continues
  Clocks multi_transaction_timer =
      0;  ///< MTT of the 430TX: for so many clocks an owner that requests the bus again comes first; 0: none
  unsigned line_words = 8;  ///< words of a cache line, a power of two
  bool host_bridge = true;  ///< master 0 is the host bridge; without one host_fair and Parking::first favour nobody
};

struct MasterConfig {
  std::string name = "master";
  Clocks latency_timer = 32;          ///< MLT: 8..248, a multiple of 8
  Clocks request_off_after_stop = 2;  ///< clocks for which REQ# is released after a retry or disconnect
  Clocks think_on_retry = 0;          ///< clocks beyond these before the master repeats a refused transaction
  unsigned max_burst = 0;             ///< the master ends its own bursts after so many words; 0: never
  bool first_level = false;           ///< with Arbitration::two_level
  unsigned agent = 0;                 ///< the master's number for targets, on whatever bus they are (see Access::agent)
};

/// How many words a target fetches ahead for a delayed read, by the read's command; 0: all words of the request.
struct Prefetch {
  unsigned read = 0;
  unsigned line = 0;
  unsigned multiple = 0;
};

/// One window of addresses of a target, and how fast it answers.
struct TargetConfig {
  std::string name = "target";
  int devsel = 2;        ///< 1 fast, 2 medium, 3 slow
  int read_initial = 3;  ///< W_i: wait states before the first data phase; devsel + W_i is at most 16
  int read_step = 0;     ///< W_s: wait states before each later data phase, at most 7
  int write_initial = 1;
  int write_step = 0;
  unsigned max_burst = 0;     ///< the target disconnects after so many words; 0: never
  bool delayed_read = false;  ///< the target refuses a read (retry) until the words are fetched
  Clocks fetch = 0;           ///< clocks of that fetch
  Prefetch prefetch{};        ///< how many words the target fetches; it disconnects after them
  unsigned post_words =
      0;  ///< length of a posted-write queue that refuses writes when full; 0: writes go straight through
  Clocks post_drain = 1;  ///< clocks for each word that leaves the queue

  static TargetConfig sram();        ///< W_i 3/1, W_s 0/0
  static TargetConfig s5933();       ///< W_i 8/2, W_s 1/1
  static TargetConfig drive_card();  ///< W_i 6/2, bursts of 8
  static TargetConfig host_dram();   ///< W_i 12/3, bursts of 8
};

/// A bridge between a processor that reads single words and posts writes, and the bus (ruling 25).
struct BridgeConfig {
  Clocks request_sync = 2;      ///< clocks from the processor's request to REQ#
  Clocks return_sync = 2;       ///< clocks from the data phase to the processor
  unsigned post_depth = 8;      ///< words of the posted-write FIFO, 1..64
  unsigned prefetch_words = 8;  ///< a read fetches up to the end of the aligned line of so many words (a power of two
                                ///< up to 64); 0 or 1: one word
  Address prefetch_limit = 0;   ///< only below this address; reads at or above it drop the line
};

/// A transparent bridge between two buses.
struct BusBridgeConfig {
  std::string name = "bridge";
  unsigned post_depth = 32;    ///< words per direction, 1 to 256
  unsigned delayed_reads = 4;  ///< reads that can be under way per direction
  unsigned prefetch_lines =
      2;  ///< lines that Memory Read Multiple fetches; Read Line fetches to the end of one line, Memory Read one word
  Clocks forward = 3;  ///< clocks from the last data phase on one bus to REQ# on the other, at least 1
  Clocks latency_timer = 32;
};

}  // namespace pci
